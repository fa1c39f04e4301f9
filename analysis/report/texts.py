"""Texts of the report: templates, number formats, captions, and sentences by heading."""

from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING

import pandas as pd

from ..anova.group_means import MODEL, is_of_fit
from ..anova.post_hoc import evidence
from ..outcomes.findings import Outcome, Primary
from ..outcomes.hierarchical_outcome import HierarchicalOutcome
from ..outcomes.ratings import REFERENCE, Ratings
from ..wording import in_unit, interval_texts, level_of, number_text, p_text, percent_text, share_text, value_of

if TYPE_CHECKING:
    from jinja2 import Environment

MOST_EVIDENCE = 10_000
"""Larger Bayes factors are printed as "> 10 000"."""


def source(name: str) -> str:
    """Return the text of a file in `templates/`."""
    return (files(__package__) / "templates" / name).read_text("utf-8")


@cache
def environment(*, is_html: bool = False) -> "Environment":
    """Return the template environment, which escapes HTML if `is_html`."""
    from jinja2 import Environment, FunctionLoader, StrictUndefined  # slow to load

    result = Environment(
        loader=FunctionLoader(source),
        autoescape=is_html,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    result.tests["known"] = pd.notna
    result.filters |= {"p": p_text, "share": share_text, "number": number_text, "percent": percent_text, "df": df_text}
    result.globals |= {"f_text": f_text, "interval": with_interval, "bayes_text": bayes_text, "evidence": evidence}
    result.globals |= {"in_unit": in_unit, "level_of": level_of, "value_of": value_of}
    return result


def lines(template: str, macro: str, *values: object, **named: object) -> list[str]:
    """Return the lines of text that a template macro makes from values."""
    text = str(getattr(environment().get_template(template).module, macro)(*values, **named))
    return [line for line in text.split("\n") if line.strip()]


def paragraph(template: str, **values: object) -> str:
    """Render a template as one paragraph."""
    return " ".join(environment().get_template(template).render(**values).split())


def with_interval(value: float, low: float, high: float, unit: str, level: str = "95 %") -> str:
    """Format a value with its unit and its confidence interval.

    >>> with_interval(-4.8125, -5.21, -4.41, "dB"), with_interval(0.02, -0.3, 0.35, "")
    ('-4.81 dB, 95 % CI [-5.21, -4.41]', '0.020, 95 % CI [-0.300, 0.350]')
    """
    texts = interval_texts(value, low, high)
    return f"{in_unit(texts[0], unit)}, {level} CI [{texts[1]}, {texts[2]}]"


def bayes_text(bf10: float) -> str:
    """Format a Bayes factor.

    >>> bayes_text(0.2312), bayes_text(143.4), bayes_text(4.3e5)
    ('BF10 = 0.23', 'BF10 = 143', 'BF10 > 10 000')
    """
    if bf10 > MOST_EVIDENCE:
        return f"BF10 > {MOST_EVIDENCE:,}".replace(",", " ")  # a comma could be read as a decimal sign
    return f"BF10 = {bf10:.2g}" if bf10 < 10 else f"BF10 = {bf10:.0f}"


def f_text(f: float, first: float, second: float, epsilon: float = 1.0) -> str:
    """Format F with its degrees of freedom, multiplied by `epsilon`.

    >>> f_text(8.1, 2, 14), f_text(8.1, 2, 14, 0.9), f_text(8.1, 1, 10.8)
    ('F(2, 14) = 8.10', 'F(1.80, 12.60) = 8.10', 'F(1, 10.8) = 8.10')
    """
    degrees = f"{first * epsilon:.2f}, {second * epsilon:.2f}" if epsilon < 1 else f"{first:.0f}, {df_text(second)}"
    return f"F({degrees}) = {f:.2f}"


def df_text(df: float) -> str:
    """Format degrees of freedom.

    >>> df_text(9.0), df_text(8.43)
    ('9', '8.4')
    """
    return f"{df:.0f}" if abs(df - round(df)) < 1e-6 else f"{df:.1f}"


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
    result = []
    for dimension, rows in table.groupby("dimension", sort=False):
        left_out = rows["left_out"].iloc[0]
        tail = f" (left out, without a score: {left_out})" if left_out else ""
        tested = rows[is_tested[rows.index]]
        result += [f"{dimension}: {text}{tail}" for text in (table_sentences(kind, tested) if len(tested) else [])]
        result += [f"{dimension}: not tested, {note}" for note in rows["note"].drop(tested.index)]
    return result


def caption(macro: str, *values: object, **named: object) -> str:
    """Return the text of a macro in `captions.j2` as one line."""
    template = environment().get_template("captions.j2").module
    return " ".join(str(getattr(template, macro)(*values, **named)).split())


def facts_of(means: pd.DataFrame) -> dict[str, object]:
    """Return the properties of a table of means that the templates use."""
    return {
        "known": [name for name in means.columns if means[name].notna().any()],
        "is_one": "n" in means.columns and means["n"].max() == 1,
        "is_of_fit": is_of_fit(means),
        "is_modelled": "method" in means.columns and bool((means["method"] == MODEL).any()),
    }


def means_text(form: str, means: pd.DataFrame, *dots: str) -> str:
    """Describe means: ``whose``, ``cells``, ``sentence`` or ``figure``.

    >>> means = pd.DataFrame({"mean": [1.0], "mean_low": [0.5], "n": [2]})
    >>> means_text("whose", means), means_text("cells", means)
    ('means over participants', 'mean, 95 % interval between participants')
    >>> means_text("figure", means, "dots are participants")
    'means over participants; bars are 95 % t-intervals between participants; dots are participants'
    >>> means_text("sentence", pd.DataFrame({"mean": [1.0], "n": [1]}))
    'Values of one participant; there is no interval between participants.'
    """
    return caption(form, facts_of(means), *dots)
