"""Sentences of outcomes, hierarchical fits and questionnaires, by the heading that they belong to."""

from collections.abc import Callable, Sequence

import pandas as pd

from ..mixed_models.linear import MixedModel
from ..outcomes.findings import Outcome, Primary
from ..outcomes.hierarchical_outcome import HierarchicalOutcome
from ..outcomes.ratings import REFERENCE, Ratings
from ..wording import number_text
from .texts import lines

COMPONENTS = {
    "threshold": "thresholds {}{}",
    "threshold_cell": "their deviations by condition {}{}",
    "log_width": "logarithms of the width {}",
    "log_width_cell": "their deviations by condition {}",
}
"""Texts of the standard deviations of a hierarchical fit, with value and unit."""


def outcome_sentences(outcome: Outcome, of_levels: str) -> dict[str, list[str]]:
    """Return all sentences by heading; `of_levels` is the unit of the levels."""
    unit = outcome.unit(of_levels).partition(" re ")[0]  # a difference has no reference
    by_heading = {} if outcome.primary is None else {outcome.heading(): primary_sentences(outcome)}
    for (name, by), table in outcome.simple.items():
        by_heading[f"Simple effects of {name} at each {by}"] = simple_sentences(table, by)
    for name, table in outcome.pairs.items():
        by_heading[f"Pairs of {name}"] = pair_sentences(table, unit, factor=name)
    for (name, by), table in outcome.simple_pairs.items():
        by_heading[f"Pairs of {name} at each {by}"] = pair_sentences(table, unit, by=by, factor=name)
    for name, table in outcome.group_pairs.items():
        by_heading[f"Groups of {name}"] = pair_sentences(table, unit, factor=name)
    for name, table in outcome.equivalence.items():
        by_heading[f"Equivalence over {name}"] = equivalence_sentences(table, unit, factor=name)

    by_heading["Assumptions"] = [] if outcome.checks is None else list(outcome.checks["text"])
    for analysis in outcome.analyses():
        if analysis is not outcome.primary:
            by_heading[f"Check: {outcome.title(analysis)}"] = analysis_sentences(outcome, analysis)
    return {heading: sentences for heading, sentences in by_heading.items() if sentences}


def primary_sentences(outcome: Outcome) -> list[str]:
    """Return the sentences of the primary analysis."""
    return [] if outcome.primary is None else analysis_sentences(outcome, outcome.primary)


def analysis_sentences(outcome: Outcome, name: Primary) -> list[str]:
    """Return the sentences of one analysis of an outcome."""
    if name is Primary.MIXED_MODEL and outcome.model is not None:
        return model_sentences(outcome.model)
    sentences = permutation_sentences if name is Primary.PERMUTATION else anova_sentences
    return sentences(outcome.analyses()[name])


def hierarchical_sentences(outcome: HierarchicalOutcome, unit: str) -> list[str]:
    """Return effects, variances and rates of a hierarchical fit, and its note."""
    components = {} if outcome.fit is None else outcome.fit.components
    unit = f" {unit.partition(' re ')[0]}" if unit else ""
    known = [name for name in COMPONENTS if name in components]
    sds = [COMPONENTS[name].format(number_text(components[name]), unit) for name in known]
    return lines("sentences.j2", "hierarchical", outcome, sds)


def form_sentences(form: Ratings) -> dict[str, list[str]]:
    """Return all sentences of a questionnaire by heading."""
    by_heading: dict[str, list[str]] = {}
    if form.crossed is not None:
        by_heading["Frequency by envelope, without the single focus"] = _by_dimension(form.crossed, anova_sentences)
    if form.against is not None:
        by_heading[f"Patterns against {REFERENCE}"] = _by_dimension(form.against, pair_sentences)
    for dimension, outcome in form.outcomes.items():
        for heading, sentences in outcome_sentences(outcome, "").items():
            by_heading.setdefault(heading, []).extend(f"{dimension}: {sentence}" for sentence in sentences)
    return by_heading | {"Consistency": alpha_sentences(form.consistency, form.factors)}


def _by_dimension(table: pd.DataFrame, sentences: Callable[[pd.DataFrame], list[str]]) -> list[str]:
    statistic = table.get("F", table.get("t"))  # missing where nothing was tested
    is_tested = pd.Series(False, table.index) if statistic is None else statistic.notna()
    found = []
    for dimension, rows in table.groupby("dimension", sort=False):
        left_out = rows["left_out"].iloc[0]
        tail = f" (left out, without a score: {left_out})" if left_out else ""
        tested = rows[is_tested[rows.index]]
        found += [f"{dimension}: {text}{tail}" for text in (sentences(tested) if len(tested) else [])]
        found += [f"{dimension}: not tested, {note}" for note in rows["note"].drop(tested.index)]
    return found


def anova_sentences(anova: pd.DataFrame) -> list[str]:
    """Return F, p and effect sizes of each effect.

    >>> row = {"Source": "force", "ddof1": 2, "ddof2": 14, "F": 38.121, "p_CM_corr": 6e-6, "eps_CM": 0.9}
    >>> size = {"np2": 0.845, "np2_low": 0.616, "np2_high": 0.892, "ng2": 0.106}
    >>> print(*anova_sentences(pd.DataFrame([row | size])))
    force: F(1.80, 12.60) = 38.12, p < .001, partial eta squared = .845, 90 % CI [.616, .892],
    generalised eta squared = .106 (Chi-Muller, epsilon = 0.90)
    """
    return lines("sentences.j2", "anova", anova.to_dict("records"))


def simple_sentences(effects: pd.DataFrame, by: str) -> list[str]:
    """Return the test of `simple_effects` at each value of `by`.

    >>> row = {"hz": 60, "Source": "force", "ddof1": 2, "ddof2": 14, "F": 8.1, "eps_CM": 1.0, "p_corr": 0.009}
    >>> simple_sentences(pd.DataFrame([row | {"np2": 0.536, "note": ""}]), "hz")
    ['hz 60: force, F(2, 14) = 8.10, p = .009 (Holm), partial eta squared = .536']
    """
    return lines("sentences.j2", "simple", effects.to_dict("records"), by)


def permutation_sentences(tested: pd.DataFrame) -> list[str]:
    """Return a sentence per effect of the permutation test.

    >>> table = pd.DataFrame({"Source": ["a * b"], "F": [1.2], "p_permutation": [0.25], "n_permutations": [512]})
    >>> permutation_sentences(table)
    ['a * b: permutation test of 512 changes of signs, F = 1.20, p = .250']
    """
    return lines("sentences.j2", "permutation", tested.to_dict("records"))


def pair_sentences(compared: pd.DataFrame, unit: str = "", by: str = "", factor: str = "") -> list[str]:
    """Return each comparison of `pairs` or `group_pairs`, at each value of `by`.

    >>> row = {"a": 60, "b": 120, "difference": -4.8125, "simultaneous_low": -5.21, "simultaneous_high": -4.41, "df": 7}
    >>> row |= {"t": -28.527, "p_unc": 1e-8, "p_corr": 1e-8, "dz": -10.09, "bf10": 4.3e5, "status": "ok"}
    >>> print(*pair_sentences(pd.DataFrame([row]), "dB", factor="frequency_hz"))
    120 Hz − 60 Hz: -4.81 dB, 95 % CI [-5.21, -4.41], t(7) = -28.53, p < .001, dz = -10.09, BF10 > 10 000,
    extreme evidence for a difference
    >>> row = {"a": "left", "b": "right", "difference": 3.0, "simultaneous_low": 0.73, "simultaneous_high": 5.27}
    >>> row |= {"df": 4.0, "t": 3.674, "p_unc": 0.021, "p_corr": 0.021, "g": 2.4, "bf10": 3.6, "status": "ok"}
    >>> print(*pair_sentences(pd.DataFrame([row]), "dB"))
    right − left: 3.00 dB, 95 % CI [0.73, 5.27], Welch's t(4) = 3.67, p = .021, g = 2.40, BF10 = 3.6,
    moderate evidence for a difference
    """
    return lines("sentences.j2", "pairs", compared.to_dict("records"), unit, by, factor)


def equivalence_sentences(tested: pd.DataFrame, unit: str = "", factor: str = "") -> list[str]:
    """Return each pair of `equivalence`, and with several pairs the verdict on all.

    >>> row = {"a": 0.5, "b": 1.0, "difference": 0.02, "low": -0.3, "high": 0.35, "p": 0.001, "equivalent": True}
    >>> table = pd.DataFrame([row])
    >>> table.attrs |= {"p_all": 0.001, "bound": 1.0, "alpha": 0.05}
    >>> print(*equivalence_sentences(table, "dB", "force_n"), sep=chr(10))
    1 N and 0.5 N are equivalent within +-1 dB: difference 0.020 dB, 90 % CI [-0.300, 0.350], TOST p = .001
    """
    verdict = {name: tested.attrs[name] for name in ("bound", "alpha", "p_all")}
    return lines("sentences.j2", "equivalence", tested.to_dict("records"), unit, factor, **verdict)


def model_sentences(model: MixedModel) -> list[str]:
    """Return terms, slopes and standard deviations of a mixed model."""
    return lines("sentences.j2", "model", model.terms.to_dict("records"), model)


def alpha_sentences(consistency: pd.DataFrame, factors: Sequence[str]) -> list[str]:
    """Return Cronbach's alpha of each row of `consistency`.

    >>> row = {"frequency_hz": 60.0, "dimension": "PQ", "alpha": None, "note": "fewer than three participants"}
    >>> alpha_sentences(pd.DataFrame([row]), ["frequency_hz"])
    ["60 Hz, PQ: no Cronbach's alpha (fewer than three participants)"]
    """
    return lines("sentences.j2", "alpha", consistency.to_dict("records"), factors)
