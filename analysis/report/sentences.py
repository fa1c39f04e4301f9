"""Sentences about outcomes, fits and questionnaires, by heading."""

import pandas as pd

from ..outcomes.findings import Outcome, Primary
from ..outcomes.hierarchical_outcome import HierarchicalOutcome
from ..outcomes.ratings import REFERENCE, Ratings
from ..wording import number_text
from .texts import lines

COMPONENTS = {
    "threshold": "thresholds {}{}",
    "threshold_cell": "threshold deviations by condition {}{}",
    "log_width": "log widths {}",
    "log_width_cell": "log width deviations by condition {}",
}
"""Texts for the standard deviations of a hierarchical fit, with value and unit."""


def outcome_sentences(outcome: Outcome, of_levels: str) -> dict[str, list[str]]:
    """Return all sentences about an outcome, by heading."""
    unit = outcome.unit(of_levels).partition(" re ")[0]  # a difference has no reference
    by_heading = {} if outcome.primary is None else {outcome.heading(): primary_sentences(outcome)}
    for (name, by), table in outcome.simple.items():
        by_heading[f"Simple effects of {name} at each {by}"] = table_sentences("simple", table, by)
    for name, table in outcome.pairs.items():
        by_heading[f"Pairs of {name}"] = table_sentences("pairs", table, unit, factor=name)
    for (name, by), table in outcome.simple_pairs.items():
        by_heading[f"Pairs of {name} at each {by}"] = table_sentences("pairs", table, unit, by, factor=name)
    for name, table in outcome.group_pairs.items():
        by_heading[f"Groups of {name}"] = table_sentences("pairs", table, unit, factor=name)
    for name, table in outcome.equivalence.items():
        by_heading[f"Equivalence over {name}"] = table_sentences("equivalence", table, table.attrs, unit, factor=name)
    by_heading["Assumptions"] = [] if outcome.checks is None else list(outcome.checks["text"])
    for analysis in outcome.analyses():
        if analysis is not outcome.primary:
            by_heading[f"Check: {outcome.title(analysis)}"] = _analysis_sentences(outcome, analysis)
    return {heading: sentences for heading, sentences in by_heading.items() if sentences}


def primary_sentences(outcome: Outcome) -> list[str]:
    """Return the sentences about the primary analysis."""
    return [] if outcome.primary is None else _analysis_sentences(outcome, outcome.primary)


def _analysis_sentences(outcome: Outcome, name: Primary) -> list[str]:
    if name is Primary.MIXED_MODEL and outcome.model is not None:
        return table_sentences("model", outcome.model.terms, outcome.model)
    kind = "permutation" if name is Primary.PERMUTATION else "anova"
    return table_sentences(kind, outcome.analyses()[name])


def table_sentences(kind: str, table: pd.DataFrame, *facts: object, **named: object) -> list[str]:
    """Return a sentence for each row, by a macro of `sentences.j2`.

    >>> row = {"Source": "force", "ddof1": 2, "ddof2": 14, "F": 38.121, "p_CM_corr": 6e-6, "eps_CM": 0.9}
    >>> size = {"np2": 0.845, "np2_low": 0.616, "np2_high": 0.892, "ng2": 0.106}
    >>> print(*table_sentences("anova", pd.DataFrame([row | size])))
    force: F(1.80, 12.60) = 38.12, p < .001, partial eta squared = .845, 90 % CI [.616, .892],
    generalised eta squared = .106 (Chi-Muller, epsilon = 0.90)
    >>> row = {"a": 60, "b": 120, "difference": -4.8125, "simultaneous_low": -5.21, "simultaneous_high": -4.41, "df": 7}
    >>> row |= {"t": -28.527, "p_unc": 1e-8, "p_corr": 1e-8, "dz": -10.09, "bf10": 4.3e5, "status": "ok"}
    >>> print(*table_sentences("pairs", pd.DataFrame([row]), "dB", factor="frequency_hz"))
    120 Hz − 60 Hz: -4.81 dB, 95 % CI [-5.21, -4.41], t(7) = -28.53, p < .001, dz = -10.09, BF10 > 10 000,
    extreme evidence for a difference
    """
    return lines("sentences.j2", kind, table.to_dict("records"), *facts, **named)


def hierarchical_sentences(outcome: HierarchicalOutcome, unit: str) -> list[str]:
    """Return sentences about effects, variances and rates of a fit."""
    components = {} if outcome.fit is None else outcome.fit.components
    unit = f" {unit.partition(' re ')[0]}" if unit else ""
    known = [name for name in COMPONENTS if name in components]
    sds = [COMPONENTS[name].format(number_text(components[name]), unit) for name in known]
    return lines("sentences.j2", "hierarchical", outcome, sds)


def form_sentences(form: Ratings) -> dict[str, list[str]]:
    """Return all sentences about a questionnaire by heading."""
    by_heading: dict[str, list[str]] = {}
    if form.crossed is not None:
        by_heading["Frequency by envelope, without the single focus"] = _by_dimension(form.crossed, "anova")
    if form.against is not None:
        by_heading[f"Patterns against {REFERENCE}"] = _by_dimension(form.against, "pairs")
    for dimension, outcome in form.outcomes.items():
        for heading, sentences in outcome_sentences(outcome, "").items():
            by_heading.setdefault(heading, []).extend(f"{dimension}: {sentence}" for sentence in sentences)
    return by_heading | {"Consistency": table_sentences("alpha", form.consistency, form.factors)}


def _by_dimension(table: pd.DataFrame, kind: str) -> list[str]:
    statistic = table.get("F", table.get("t"))  # missing if nothing was tested
    is_tested = pd.Series(False, table.index) if statistic is None else statistic.notna()
    found = []
    for dimension, rows in table.groupby("dimension", sort=False):
        left_out = rows["left_out"].iloc[0]
        tail = f" (left out, without a score: {left_out})" if left_out else ""
        tested = rows[is_tested[rows.index]]
        found += [f"{dimension}: {text}{tail}" for text in (table_sentences(kind, tested) if len(tested) else [])]
        found += [f"{dimension}: not tested, {note}" for note in rows["note"].drop(tested.index)]
    return found
