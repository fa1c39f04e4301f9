"""Every sentence of an outcome, of a hierarchical outcome, and of a questionnaire, from its numbers, in the form of the
American Psychological Association."""

from collections.abc import Callable, Sequence
from typing import Any

import pandas as pd

from ..anova.post_hoc import evidence
from ..hierarchical.fitting import FactorEffect, HierarchicalFit
from ..mixed_models.linear import MixedModel
from ..outcomes.findings import Outcome, Primary
from ..outcomes.hierarchical_outcome import HierarchicalOutcome
from ..outcomes.ratings import REFERENCE, Ratings
from ..wording import in_unit, interval_texts, level_of, number_text, p_text, percent_text, share_text, value_of

INTERVAL_OF_ETA = "90 %"
MOST_EVIDENCE = 10_000
"""A larger Bayes factor is told as larger."""


def outcome_sentences(outcome: Outcome, of_levels: str) -> dict[str, list[str]]:
    """Every sentence, by the heading that it stands under; `of_levels` is the unit of the levels."""
    by_heading = {} if outcome.primary is None else {outcome.heading(): primary_sentences(outcome)}
    by_heading |= _comparisons(outcome, outcome.unit(of_levels).partition(" re ")[0])  # a difference has no reference
    by_heading["Assumptions"] = [] if outcome.checks is None else list(outcome.checks["text"])
    for name in outcome.analyses():
        if name is not outcome.primary:
            by_heading[f"Check: {outcome.title(name)}"] = analysis_sentences(outcome, name)
    return {heading: sentences for heading, sentences in by_heading.items() if sentences}


def primary_sentences(outcome: Outcome) -> list[str]:
    """Of the analysis that answers."""
    return [] if outcome.primary is None else analysis_sentences(outcome, outcome.primary)


def analysis_sentences(outcome: Outcome, name: Primary) -> list[str]:
    """Of one of its analyses."""
    if name is Primary.MIXED_MODEL and outcome.model is not None:
        return model_sentences(outcome.model)
    sentences = permutation_sentences if name is Primary.PERMUTATION else anova_sentences
    return sentences(outcome.analyses()[name])


def _comparisons(outcome: Outcome, unit: str) -> dict[str, list[str]]:
    by_heading = {}
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
    return by_heading


def hierarchical_sentences(outcome: HierarchicalOutcome, unit: str) -> list[str]:
    """Effects, variances and rates, and what a reader must know."""
    if outcome.fit is None:
        return [outcome.note]
    tested = [f"{name}: Wald's {_f_text(effect)}, {p_text(effect.p)}" for name, effect in outcome.effects.items()]
    return [*tested, *_variance_sentences(outcome.fit, unit), *([outcome.note] if outcome.note else [])]


def _f_text(effect: FactorEffect) -> str:
    return f_text(effect.f, effect.df, effect.df_error, effect.epsilon)


def _variance_sentences(fit: HierarchicalFit, unit: str) -> list[str]:
    unit = f" {unit.partition(' re ')[0]}" if unit else ""
    names = {
        "threshold": f"thresholds {{}}{unit}",
        "threshold_cell": f"their deviations by condition {{}}{unit}",
        "log_width": "logarithms of the width {}",
        "log_width_cell": "their deviations by condition {}",
    }
    sds = [text.format(number_text(fit.components[name])) for name, text in names.items() if name in fit.components]
    rates = {"mean lapse rate": fit.lapse_rate, "guess rate of all": fit.guess_rate}
    rate_texts = [f"{name} {rate:.3f}" for name, rate in rates.items() if rate]
    spread = f"standard deviations between {fit.n_participants} participants: {', '.join(sds)}" if sds else ""
    return [text for text in (spread, ", ".join(rate_texts)) if text]


def form_sentences(form: Ratings) -> dict[str, list[str]]:
    """Every sentence of a questionnaire, by the heading that it stands under."""
    by_heading: dict[str, list[str]] = {}
    if form.crossed is not None:
        by_heading["Frequency by envelope, without the single focus"] = _by_dimension(form.crossed, anova_sentences)
    if form.against is not None:
        by_heading[f"Patterns against {REFERENCE}"] = _by_dimension(form.against, pair_sentences)
    for dimension, outcome in form.outcomes.items():
        for heading, lines in outcome_sentences(outcome, "").items():
            by_heading.setdefault(heading, []).extend(f"{dimension}: {line}" for line in lines)
    return by_heading | {"Consistency": alpha_sentences(form.consistency, form.factors)}


def _by_dimension(table: pd.DataFrame, sentences: Callable[[pd.DataFrame], list[str]]) -> list[str]:
    statistic = next((name for name in ("F", "t") if name in table.columns), None)  # none where nothing was tested
    is_tested = pd.Series(False, table.index) if statistic is None else table[statistic].notna()
    lines = []
    for dimension, rows in table.groupby("dimension", sort=False):
        left_out = rows["left_out"].iloc[0]
        tail = f" (left out, without a score: {left_out})" if left_out else ""
        tested = rows[is_tested[rows.index]]
        lines += [f"{dimension}: {text}{tail}" for text in (sentences(tested) if len(tested) else [])]
        lines += [f"{dimension}: not tested, {note}" for note in rows["note"].drop(tested.index)]
    return lines


def _with_interval(value: float, low: float, high: float, unit: str, level: str = "95 %") -> str:
    """
    >>> _with_interval(-4.8125, -5.21, -4.41, "dB"), _with_interval(0.02, -0.3, 0.35, "")
    ('-4.81 dB, 95 % CI [-5.21, -4.41]', '0.020, 95 % CI [-0.300, 0.350]')
    """
    texts = interval_texts(value, low, high)
    return f"{in_unit(texts[0], unit)}, {level} CI [{texts[1]}, {texts[2]}]"


def bayes_text(bf10: float) -> str:
    """
    >>> bayes_text(0.2312), bayes_text(143.4), bayes_text(4.3e5)
    ('BF10 = 0.23', 'BF10 = 143', 'BF10 > 10 000')
    """
    if bf10 > MOST_EVIDENCE:
        return f"BF10 > {MOST_EVIDENCE:,}".replace(",", " ")  # a comma may be read as a decimal sign
    return f"BF10 = {bf10:.2g}" if bf10 < 10 else f"BF10 = {bf10:.0f}"


def anova_sentences(anova: pd.DataFrame) -> list[str]:
    """For each effect F, corrected degrees of freedom where there is a correction, p, partial eta squared with its
    interval and generalised eta squared.

    >>> row = {"Source": "force", "ddof1": 2, "ddof2": 14, "F": 38.121, "p_CM_corr": 6e-6, "eps_CM": 0.9}
    >>> size = {"np2": 0.845, "np2_low": 0.616, "np2_high": 0.892, "ng2": 0.106}
    >>> print(*anova_sentences(pd.DataFrame([row | size])))
    force: F(1.80, 12.60) = 38.12, p < .001, partial eta squared = .845, 90 % CI [.616, .892],
    generalised eta squared = .106 (Chi-Muller, epsilon = 0.90)
    """
    return [_anova_sentence(row) for _, row in anova.iterrows() if pd.notna(row["F"])]


def _anova_sentence(row: "pd.Series[Any]") -> str:
    size = (
        f"partial eta squared = {share_text(row['np2'])}, {INTERVAL_OF_ETA} CI [{share_text(row['np2_low'])}, "
        f"{share_text(row['np2_high'])}], generalised eta squared = {share_text(row['ng2'])}"
    )
    f = f_text(row["F"], row["ddof1"], row["ddof2"], row["eps_CM"])
    corrected = f" (Chi-Muller, epsilon = {row['eps_CM']:.2f})" if row["eps_CM"] < 1 else ""
    return f"{row['Source']}: {f}, {p_text(row['p_CM_corr'])}, {size}{corrected}"


def simple_sentences(effects: pd.DataFrame, by: str) -> list[str]:
    """One for each value of `by`, of `simple_effects`.

    >>> row = {"hz": 60, "Source": "force", "ddof1": 2, "ddof2": 14, "F": 8.1, "eps_CM": 1.0, "p_corr": 0.009}
    >>> simple_sentences(pd.DataFrame([row | {"np2": 0.536, "note": ""}]), "hz")
    ['hz 60: force, F(2, 14) = 8.10, p = .009 (Holm), partial eta squared = .536']
    """
    return [f"{value_of(by, row[by])}: {row['Source']}, {_simple_effect(row)}" for _, row in effects.iterrows()]


def _simple_effect(row: "pd.Series[Any]") -> str:
    if pd.isna(row["F"]):
        return f"not tested, {row['note'] or 'the error is 0'}"
    f = f_text(row["F"], row["ddof1"], row["ddof2"], row["eps_CM"])
    return f"{f}, {p_text(row['p_corr'])} (Holm), partial eta squared = {share_text(row['np2'])}"


def f_text(f: float, first: float, second: float, epsilon: float = 1.0) -> str:
    """F with its degrees of freedom, corrected where they are.

    >>> f_text(8.1, 2, 14), f_text(8.1, 2, 14, 0.9), f_text(8.1, 1, 10.8)
    ('F(2, 14) = 8.10', 'F(1.80, 12.60) = 8.10', 'F(1, 10.8) = 8.10')
    """
    degrees = f"{first * epsilon:.2f}, {second * epsilon:.2f}" if epsilon < 1 else f"{first:.0f}, {_df(second)}"
    return f"F({degrees}) = {f:.2f}"


def permutation_sentences(tested: pd.DataFrame) -> list[str]:
    """
    >>> table = pd.DataFrame({"Source": ["a * b"], "F": [1.2], "p_permutation": [0.25], "n_permutations": [512]})
    >>> permutation_sentences(table)
    ['a * b: permutation test of 512 changes of signs, F = 1.20, p = .250']
    """
    return [
        f"{row['Source']}: permutation test of {row['n_permutations']} changes of signs, F = {row['F']:.2f}, "
        f"{p_text(row['p_permutation'])}"
        for _, row in tested.iterrows()
    ]


PAIRED = "t", "dz", " in every participant"
WELCH = "Welch's t", "g", ", alike in all participants of a group"
"""How a comparison of two conditions is told: its statistic, the column of its size, and of which values it is said
that they do not vary."""


def pair_sentences(compared: pd.DataFrame, unit: str = "", by: str = "", factor: str = "") -> list[str]:
    """One for each comparison of `pairs` or of `group_pairs`; `by` is a factor at each of whose values they were
    compared, `factor` the one that was compared: its name says the unit.

    >>> row = {"a": 60, "b": 120, "difference": -4.8125, "simultaneous_low": -5.21, "simultaneous_high": -4.41, "df": 7}
    >>> row |= {"t": -28.527, "p_unc": 1e-8, "p_corr": 1e-8, "dz": -10.09, "bf10": 4.3e5, "status": "ok"}
    >>> print(*pair_sentences(pd.DataFrame([row]), "dB", factor="frequency_hz"))
    120 Hz less 60 Hz: -4.81 dB, 95 % CI [-5.21, -4.41], t(7) = -28.53, p < .001, dz = -10.09, BF10 > 10 000,
    extreme evidence for a difference
    >>> row = {"a": "left", "b": "right", "difference": 3.0, "simultaneous_low": 0.73, "simultaneous_high": 5.27}
    >>> row |= {"df": 4.0, "t": 3.674, "p_unc": 0.021, "p_corr": 0.021, "g": 2.4, "bf10": 3.6, "status": "ok"}
    >>> print(*pair_sentences(pd.DataFrame([row]), "dB"))
    right less left: 3.00 dB, 95 % CI [0.73, 5.27], Welch's t(4) = 3.67, p = .021, g = 2.40, BF10 = 3.6,
    moderate evidence for a difference
    """
    test = PAIRED if PAIRED[1] in compared.columns else WELCH
    n_tested = int(compared["p_unc"].notna().sum())
    return [
        f"{f'{value_of(by, row[by])}: ' if by else ''}{level_of(factor, row['b'])} less {level_of(factor, row['a'])}: "
        f"{_comparison(row, test, unit, n_tested)}"
        for _, row in compared.iterrows()
    ]


def _comparison(row: "pd.Series[Any]", test: tuple[str, str, str], unit: str, n_tested: int) -> str:
    """Difference, interval, t, p, size and Bayes factor; of several comparisons the interval and the p of all
    together."""
    statistic, size, without_error = test
    if row["status"] != "ok":
        difference = in_unit(number_text(row["difference"]), unit)
        return f"{difference}{without_error}: no test, as there is no error"
    level, correction = ("95 % simultaneous", " (Holm)") if n_tested > 1 else ("95 %", "")
    difference = _with_interval(row["difference"], row["simultaneous_low"], row["simultaneous_high"], unit, level)
    t = f"{statistic}({_df(row['df'])}) = {row['t']:.2f}, {p_text(row['p_corr'])}{correction}"
    bayes = f", {bayes_text(row['bf10'])}, {evidence(row['bf10'])}" if pd.notna(row["bf10"]) else ""
    return f"{difference}, {t}, {size} = {row[size]:.2f}{bayes}"


def _df(df: float) -> str:
    """
    >>> _df(9.0), _df(8.43)
    ('9', '8.4')
    """
    return f"{df:.0f}" if abs(df - round(df)) < 1e-6 else f"{df:.1f}"


def equivalence_sentences(tested: pd.DataFrame, unit: str = "", factor: str = "") -> list[str]:
    """One for each pair of `equivalence`, and of several one for all of them together.

    >>> row = {"a": 0.5, "b": 1.0, "difference": 0.02, "low": -0.3, "high": 0.35, "p": 0.001, "equivalent": True}
    >>> table = pd.DataFrame([row])
    >>> table.attrs |= {"p_all": 0.001, "bound": 1.0, "alpha": 0.05}
    >>> print(*equivalence_sentences(table, "dB", "force_n"), sep=chr(10))
    1 N and 0.5 N are equivalent within +-1 dB: difference 0.020 dB, 90 % CI [-0.300, 0.350], TOST p = .001
    """
    level = percent_text(1 - 2 * tested.attrs["alpha"])
    bound = in_unit(f"+-{tested.attrs['bound']:g}", unit)
    of_pairs = [
        f"{level_of(factor, row['b'])} and {level_of(factor, row['a'])} "
        f"{'are' if row['equivalent'] else 'were not shown to be'} equivalent within {bound}: difference "
        f"{_with_interval(row['difference'], row['low'], row['high'], unit, level)}, TOST {p_text(row['p'])}"
        for _, row in tested.iterrows()
    ]
    if len(of_pairs) == 1:
        return of_pairs
    verdict = "are" if tested.attrs["p_all"] < tested.attrs["alpha"] else "were not all shown to be"
    all_of_them = f"all {len(tested)} pairs" if verdict == "are" else f"the {len(tested)} pairs"
    return [
        *of_pairs,
        f"{all_of_them} {verdict} equivalent within {bound}, largest TOST {p_text(tested.attrs['p_all'])}",
    ]


def model_sentences(model: MixedModel) -> list[str]:
    """The terms of a mixed model, its slopes, and its variances as standard deviations."""
    terms = [
        f"{row['term']}: F({row['df1']}, {row['df2']}) = {row['F']:.2f}, {p_text(row['p'])}"
        for _, row in model.terms.iterrows()
    ]
    return [
        *terms,
        f"standard deviation between participants {number_text(model.participant_sd)}, residual "
        f"{number_text(model.residual_sd)} "
        f"({model.n} values of {model.n_participants} participants{_censoring_text(model.n_censored)})",
        *model.notes,
    ]


def _censoring_text(n: int) -> str:
    """
    >>> _censoring_text(0), _censoring_text(2)
    ('', '; 2 of them bounds of censored thresholds, by maximum likelihood')
    """
    bounds = "the bound of a censored threshold" if n == 1 else "bounds of censored thresholds"
    return f"; {n} of them {bounds}, by maximum likelihood" if n else ""


def alpha_sentences(consistency: pd.DataFrame, factors: Sequence[str]) -> list[str]:
    """Cronbach's alpha of each row of `consistency`.

    >>> row = {"frequency_hz": 60.0, "dimension": "PQ", "alpha": None, "note": "fewer than three participants"}
    >>> alpha_sentences(pd.DataFrame([row]), ["frequency_hz"])
    ["60 Hz, PQ: no Cronbach's alpha (fewer than three participants)"]
    """
    return [
        f"{', '.join([*(value_of(name, row[name]) for name in factors), row['dimension']])}: {_alpha_text(row)}"
        for _, row in consistency.iterrows()
    ]


def _alpha_text(row: "pd.Series[Any]") -> str:
    if pd.isna(row["alpha"]):
        return f"no Cronbach's alpha ({row['note']})"
    ends = f"[{share_text(row['alpha_low'])}, {share_text(row['alpha_high'])}]"
    return f"Cronbach's alpha = {share_text(row['alpha'])}, 95 % CI {ends}, n = {row['n']}"
