"""All participants at once: the hierarchical model as a check of the primary analysis."""

from collections.abc import Iterator

from ...figures import psychophysics
from ...outcomes.hierarchical_outcome import HierarchicalOutcome
from ...result import Analysis
from ...tasks.kinds import CURVES
from ...wording import cross_table, dependent_name, dependent_title, with_unit
from ..section import Blocks, Details, Figure, Lead, ResultKind, Section, Sentences, TextTable, grid, plain_rows
from ..sentences import hierarchical_sentences

MEANS = {"threshold": "mean", "interval_low": "mean_low", "interval_high": "mean_high"}
"""Columns of the conditions, as those of a group table."""


def _sections(analysis: Analysis) -> Iterator[Section]:
    for outcome in analysis.hierarchical:
        task = f" ({outcome.task.replace('_', ' ')})" if len(analysis.hierarchical) > 1 else ""
        yield Section(f"All participants at once{task}", tuple(_blocks(outcome, analysis)))


def _blocks(outcome: HierarchicalOutcome, analysis: Analysis) -> Blocks:
    sentences = Sentences(hierarchical_sentences(outcome, analysis.unit))
    if outcome.fit is None:
        yield sentences
        return
    values = "points of subjective equality" if _dependent(outcome) == "pse" else "thresholds"
    yield Lead(
        f"A check of the primary analysis. Hierarchical model: {values} of the group with 95 % interval; "
        "estimates of participants are drawn to the group as far as their answers leave it open."
    )
    yield grid(cross_table(outcome.conditions, outcome.fit.factors), analysis.factors)
    yield _figure(outcome, analysis)
    yield sentences
    yield Details(f"Participants ({len(outcome.participants)} rows)", (grid(outcome.participants, analysis.factors),))


def _dependent(outcome: HierarchicalOutcome) -> str:
    return CURVES[outcome.task].dependents[0]


def _figure(outcome: HierarchicalOutcome, analysis: Analysis) -> Figure:
    name = dependent_title(_dependent(outcome))
    means, factors = outcome.conditions.rename(columns=MEANS), [f for f in analysis.factors if f in outcome.conditions]
    label = with_unit(name, analysis.unit)
    drawing = psychophysics.threshold_figure(means, outcome.participants, factors, "threshold", label)
    bars = " with 95 % intervals" if outcome.conditions["interval_low"].notna().any() else ""
    text = f"{name}: the hierarchical model's means{bars}; faint dots are participants, drawn to the group."
    stem = f"hierarchical_{outcome.task}"
    return Figure(stem, drawing, text, stem)


def _terminal(analysis: Analysis) -> Iterator[TextTable]:
    for outcome in analysis.hierarchical:
        if outcome.fit is not None:
            unit = f", {analysis.unit}" if analysis.unit else ""
            name = dependent_name(_dependent(outcome))
            title = f"check, all participants at once: {name}{unit} (mean, 95 % interval)"
            cross = cross_table(outcome.conditions, outcome.fit.factors)
            yield TextTable(cross, title, hierarchical_sentences(outcome, analysis.unit))


def _values(analysis: Analysis) -> Iterator[tuple[str, object]]:
    yield "hierarchical", [_plain(outcome, analysis.unit) for outcome in analysis.hierarchical]


def _plain(outcome: HierarchicalOutcome, unit: str) -> dict[str, object]:
    return {
        "task": outcome.task,
        "status": None if outcome.fit is None else outcome.fit.status.value,
        "conditions": plain_rows(outcome.conditions),
        "participants": plain_rows(outcome.participants),
        "components": {} if outcome.fit is None else dict(outcome.fit.components),
        "sentences": hierarchical_sentences(outcome, unit),
    }


KIND = ResultKind(_sections, _terminal, _values)
