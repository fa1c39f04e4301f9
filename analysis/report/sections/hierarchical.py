"""All participants at once: the hierarchical model as a check of the primary analysis."""

from collections.abc import Iterator

from ...figures import group
from ...outcomes.hierarchical_outcome import HierarchicalOutcome
from ...result import Analysis
from ...tasks.kinds import CURVES
from ...wording.cross_table import cross_table
from ...wording.labels import dependent_name, dependent_title, with_unit
from ..grid import grid
from ..section import Block, Details, Figure, Kind, Lead, Section, Sentences, TableBlock, TextTable, plain_rows
from ..sentences import hierarchical_sentences

MEANS = {"threshold": "mean", "interval_low": "mean_low", "interval_high": "mean_high"}
"""Columns of the conditions, as those of a group table."""


def _sections(found: Analysis) -> Iterator[Section]:
    for outcome in found.hierarchical:
        task = f" ({outcome.task.replace('_', ' ')})" if len(found.hierarchical) > 1 else ""
        yield Section(f"All participants at once{task}", tuple(_blocks(outcome, found)))


def _blocks(outcome: HierarchicalOutcome, found: Analysis) -> Iterator[Block]:
    told = Sentences(hierarchical_sentences(outcome, found.unit))
    if outcome.fit is None:
        yield told
        return
    factors = found.trials.factors
    yield Lead(
        f"A check of the primary analysis. Hierarchical model: {_values_of(outcome)} of the group with 95 % interval; "
        "estimates of participants are drawn to the group as far as their answers leave it open."
    )
    yield TableBlock(grid(cross_table(outcome.conditions, outcome.fit.factors), factors))
    yield _figure(outcome, found)
    yield told
    participants = grid(outcome.participants, factors)
    yield Details(f"Participants ({len(participants.rows)} rows)", (TableBlock(participants),))


def _values_of(outcome: HierarchicalOutcome) -> str:
    return "points of subjective equality" if _dependent(outcome) == "pse" else "thresholds"


def _dependent(outcome: HierarchicalOutcome) -> str:
    return CURVES[outcome.task].dependents[0]


def _figure(outcome: HierarchicalOutcome, found: Analysis) -> Figure:
    name = dependent_title(_dependent(outcome))
    drawing = group.threshold_figure(
        outcome.conditions.rename(columns=MEANS),
        [factor for factor in found.trials.factors if factor in outcome.conditions.columns],
        label=with_unit(name, found.unit),
        individuals=outcome.participants,
        dependent="threshold",
    )
    bars = " with 95 % intervals" if outcome.conditions["interval_low"].notna().any() else ""
    text = f"{name}: the hierarchical model's means{bars}; faint dots are participants, drawn to the group."
    stem = f"hierarchical_{outcome.task}"
    return Figure(stem, drawing, text, stem)


def _terminal(found: Analysis) -> Iterator[TextTable]:
    for outcome in found.hierarchical:
        if outcome.fit is not None:
            unit = f", {found.unit}" if found.unit else ""
            name = dependent_name(_dependent(outcome))
            title = f"check, all participants at once: {name}{unit} (mean, 95 % interval)"
            cross = cross_table(outcome.conditions, outcome.fit.factors)
            yield TextTable(cross, title, hierarchical_sentences(outcome, found.unit))


def _values(found: Analysis) -> Iterator[tuple[str, object]]:
    yield "hierarchical", [_plain(outcome, found.unit) for outcome in found.hierarchical]


def _plain(outcome: HierarchicalOutcome, unit: str) -> dict[str, object]:
    return {
        "task": outcome.task,
        "status": None if outcome.fit is None else outcome.fit.status.value,
        "conditions": plain_rows(outcome.conditions),
        "participants": plain_rows(outcome.participants),
        "components": {} if outcome.fit is None else dict(outcome.fit.components),
        "sentences": hierarchical_sentences(outcome, unit),
    }


HIERARCHICAL = Kind(_sections, _terminal, _values)
