"""Dependent variables with their analyses, and the hierarchical model."""

from collections.abc import Iterator, Sequence
from functools import partial

import pandas as pd

from ...anova.group_means import HIGH, LOW, bounds_of, is_of_fit
from ...figures import psychophysics
from ...outcomes.findings import Outcome
from ...outcomes.hierarchical_outcome import HierarchicalOutcome
from ...result import Analysis
from ...tasks.kinds import CURVES
from ...tasks.magnitude import DEPENDENT as EXPONENT, GROWTH
from ...wording import cross_table, dependent_name, dependent_title, in_words, interval_text, p_text, with_unit
from ..section import Blocks, Figure, Folded, Heading, Lead, ResultKind, Section, Sentences, TextTable, details, grid
from ..texts import caption, facts_of, hierarchical_sentences, means_text, outcome_sentences, primary_sentences

EFFECT_COLUMNS = {
    "Source": "effect", "term": "effect", "SS": "SS", "ddof1": "df 1", "ddof2": "df 2", "df1": "df 1", "df2": "df 2",
    "F": "F", "eps_CM": "epsilon", "p_CM_corr": "p (df × epsilon)", "p": "p", "p_permutation": "p",
    "np2": "partial eta²", "ng2": "generalised eta²",
}  # fmt: skip
"""Columns of the primary analysis shown on the page; the CSV file contains all columns."""
MEANS = {"threshold": "mean", "interval_low": "mean_low", "interval_high": "mean_high"}
"""Names in a group table for the columns of a hierarchical fit's conditions."""
DECIBELS = "dB re 1 "
P_COLUMNS = ("p_CM_corr", "p", "p_permutation")


def _sections(analysis: Analysis) -> Iterator[Section]:
    for outcome in analysis.outcomes:
        title = with_unit(dependent_title(outcome.dependent), outcome.unit(analysis.unit))
        yield Section(title, tuple(_blocks(outcome, analysis)))
    for check in analysis.hierarchical:
        task = f" ({check.task.replace('_', ' ')})" if len(analysis.hierarchical) > 1 else ""
        yield Section(f"Hierarchical model of all participants{task}", tuple(_check_blocks(check, analysis)))


def _blocks(outcome: Outcome, analysis: Analysis) -> Blocks:
    factors = outcome.factors
    yield Lead(means_text("sentence", outcome.group))
    yield grid(outcome.cross, factors)
    unit = outcome.unit(analysis.unit)
    if unit.startswith(DECIBELS) and outcome.group["mean"].notna().any():
        is_peak = bool(analysis.study.procedure)  # the levels of Tactometry's stimuli are peak values
        yield Lead(caption("amplitudes_lead", unit.removeprefix(DECIBELS), is_peak))
        yield grid(cross_table(as_amplitudes(outcome.group), factors), factors)
    yield _figure(outcome, analysis)
    if outcome.dependent == EXPONENT and GROWTH in analysis.tables:
        draw = partial(psychophysics.growth_figure, analysis.tables[GROWTH], analysis.factors, unit=analysis.unit)
        yield Figure(GROWTH, draw, caption("growth"), GROWTH)
    sentences = outcome_sentences(outcome, analysis.unit)
    if outcome.effects is not None:
        heading = outcome.heading()
        yield Heading(in_words(heading, factors))
        yield grid(_effect_columns(outcome.effects, factors), ())
        # The primary analysis is unfolded; the others are folded below it.
        yield Sentences(sentences.pop(heading, []))
    yield Folded(sentences, n_open=2)


def as_amplitudes(group: pd.DataFrame) -> pd.DataFrame:
    """Return a group table with amplitudes 10^(level / 20) as `text`.

    Cells without a mean keep their text.

    >>> as_amplitudes(pd.DataFrame({"mean": [20.0], "mean_low": [0.0], "mean_high": [40.0], "text": [""]}))["text"][0]
    '10.0 [1.0, 100.0]'
    """
    amplitudes = 10 ** (group[["mean", "mean_low", "mean_high"]].astype(float) / 20)
    rows = zip(group["text"], amplitudes.itertuples(index=False), strict=True)
    return group.assign(text=[text if pd.isna(row[0]) else interval_text(*row) for text, row in rows])


def _figure(outcome: Outcome, analysis: Analysis) -> Figure:
    name, values = dependent_title(outcome.dependent), bounds_of(outcome.estimates, outcome.dependent)
    label = with_unit(name, outcome.unit(analysis.unit))
    if is_of_fit(outcome.group):  # omit values that equal the means
        values = values[values[outcome.dependent].isna()]
    draw = partial(psychophysics.threshold_figure, outcome.group, values, outcome.factors, outcome.dependent, label)
    has_bounds = values[[LOW, HIGH]].notna().any(axis=None)
    stem = analysis.stem(outcome)
    return Figure(stem, draw, caption("dependent", name, facts_of(outcome.group), has_bounds), f"group_{stem}")


def _effect_columns(table: pd.DataFrame, factors: Sequence[str]) -> pd.DataFrame:
    effects = table[table["F"].notna()]
    shown = effects[[name for name in EFFECT_COLUMNS if name in effects.columns]].copy()
    for name in set(P_COLUMNS) & set(shown.columns):
        shown[name] = [p_text(p).removeprefix("p ").removeprefix("= ") for p in shown[name].astype(float)]
    for name in {"Source", "term"} & set(shown.columns):
        shown[name] = [in_words(source, factors) for source in shown[name]]
    return shown.rename(columns=EFFECT_COLUMNS)


def _check_blocks(check: HierarchicalOutcome, analysis: Analysis) -> Blocks:
    sentences = Sentences(hierarchical_sentences(check, analysis.unit))
    if check.fit is None:
        yield sentences
        return
    dependent, factors = CURVES[check.task].dependents[0], check.fit.factors
    yield Lead(caption("check_lead", dependent == "pse"))
    yield grid(cross_table(check.conditions, factors), analysis.factors)
    name, means = dependent_title(dependent), check.conditions.rename(columns=MEANS)
    label = with_unit(name, analysis.unit)
    draw = partial(psychophysics.threshold_figure, means, check.participants, factors, "threshold", label)
    text = caption("check", name, means["mean_low"].notna().any())
    yield Figure(f"hierarchical_{check.task}", draw, text, f"hierarchical_{check.task}")
    yield sentences
    yield details("Participants", check.participants, analysis.factors)


def _terminal(analysis: Analysis) -> Iterator[TextTable]:
    for outcome in analysis.outcomes:
        unit = outcome.unit(analysis.unit)
        name = dependent_name(outcome.dependent) + (f", {unit}" if unit else "")
        primary = [outcome.heading(), *primary_sentences(outcome)] if outcome.primary else []
        title = f"{name} ({means_text('cells', outcome.group)}, n)"
        yield TextTable(outcome.cross, title, [*outcome.notes, *primary], across="condition")
    for check in analysis.hierarchical:
        if check.fit is None:
            continue
        name = dependent_name(CURVES[check.task].dependents[0]) + (f", {analysis.unit}" if analysis.unit else "")
        title = f"check with a hierarchical model: {name} (mean, 95 % interval)"
        cross = cross_table(check.conditions, check.fit.factors)
        yield TextTable(cross, title, hierarchical_sentences(check, analysis.unit), across="condition")


def _values(analysis: Analysis) -> Iterator[tuple[str, object]]:
    yield "outcomes", [_values_of_outcome(outcome, analysis.unit) for outcome in analysis.outcomes]
    yield "hierarchical", [_values_of_check(check, analysis.unit) for check in analysis.hierarchical]


def _values_of_outcome(outcome: Outcome, unit: str) -> dict[str, object]:
    primary = None
    if outcome.primary is not None and outcome.effects is not None:
        primary = {
            "analysis": outcome.primary.value,
            "title": outcome.title(outcome.primary),
            "reason": outcome.reason,
            "effects": outcome.effects,
        }
    return {
        "task": outcome.task,
        "dependent": outcome.dependent,
        "group": outcome.group,
        "primary": primary,
        "checks": [outcome.title(name) for name in outcome.analyses() if name is not outcome.primary],
        "anova": outcome.anova,
        "left_out": list(outcome.left_out),
        "status": None if outcome.status is None else outcome.status.value,
        "sentences": primary_sentences(outcome),
        "statistics": outcome_sentences(outcome, unit),
        "notes": list(outcome.notes),
    }


def _values_of_check(check: HierarchicalOutcome, unit: str) -> dict[str, object]:
    return {
        "task": check.task,
        "status": None if check.fit is None else check.fit.status.value,
        "conditions": check.conditions,
        "participants": check.participants,
        "components": {} if check.fit is None else dict(check.fit.components),
        "sentences": hierarchical_sentences(check, unit),
    }


KIND = ResultKind(_sections, _terminal, _values)
