"""Rates of answers against the level."""

from collections.abc import Iterator

from ...figures.psychophysics import mean_rate_figure, rate_figure
from ...result import Analysis
from ...tasks.cells import MAX_LEVELS
from ...tasks.kinds import CURVES
from ..section import Figure, ResultKind, Section


def _sections(analysis: Analysis) -> Iterator[Section]:
    # cells without a level hold catch trials alone
    tasks = sorted({estimate.cell.task for estimate in analysis.estimates if estimate.cell.levels} & set(CURVES))
    if tasks:
        yield Section("Rates", tuple(figure for task in tasks for figure in _figures(analysis, task)))


def _figures(analysis: Analysis, task: str) -> Iterator[Figure]:
    factors, kind, of = analysis.factors, CURVES[task].rate_label, ("task", task)
    rates, means, counts = (
        table[table["task"] == task] for table in map(analysis.tables.__getitem__, ("rates", "mean_rates", "counts"))
    )
    is_one = counts["participant"].nunique() == 1
    classes = f"; levels in {MAX_LEVELS} classes, each at its mean" if counts["level"].nunique() > MAX_LEVELS else ""
    text = f"{kind} against level, {'one participant' if is_one else 'all participants together'}{classes}."
    yield Figure(f"rates_{task}", rate_figure(rates, factors, unit=analysis.unit), text, "rates", of)
    if factors and not _is_tracked(analysis, task):
        text = f"{kind} over all levels, {'one participant' if is_one else 'mean over participants'}."
        yield Figure(f"mean_rates_{task}", mean_rate_figure(means, factors), text, "mean_rates", of)


def _is_tracked(analysis: Analysis, task: str) -> bool:
    """Whether levels followed the answers: the rate over all of them then tells of the procedure alone."""
    return "tracks" in analysis.tables and task in set(analysis.tables["tracks"]["task"])


KIND = ResultKind(_sections)
