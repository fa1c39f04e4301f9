"""Data quality: trials recorded and used, goodness of fit, and exclusions."""

from collections.abc import Iterator

from ...result import Analysis
from ..section import Blocks, Heading, Lead, ResultKind, Section, TextGrid, grid, rows_of

COLUMNS = {
    "n_rows": "rows", "n_practice": "practice", "n_invalid": "invalid", "n_repeated": "asked again",
    "n_unanswered": "unanswered", "n_catch": "catch trials", "n_false_alarms": "false alarms",
    "practice_missed": "practice missed",
    "false_alarm_rate": "rate of false alarms", "n_frames": "frames", "n_dropped_frames": "dropped frames",
    "n_tested": "functions", "n_flagged": "with p ≤ .01", "n_by_chance": "by chance", "meaning": "what a small p says",
}  # fmt: skip
"""Headings of the tables of data quality and goodness of fit."""
GOODNESS = (
    "Tests of the fitted functions with p ≤ .01, and how many chance alone would flag. Which functions: column misfit "
    "of thresholds.csv."
)


def _table(analysis: Analysis, name: str) -> TextGrid:
    return grid(analysis.tables[name].rename(columns=COLUMNS), analysis.factors)


def _blocks(analysis: Analysis) -> Blocks:
    yield _table(analysis, "quality")
    if "goodness" in analysis.tables:
        yield from (Heading("Goodness of fit"), Lead(GOODNESS), _table(analysis, "goodness"))
    if "excluded" in analysis.tables:
        yield from (Heading("Left out by the plan of analysis"), _table(analysis, "excluded"))


def _sections(analysis: Analysis) -> Iterator[Section]:
    yield Section("Data quality", tuple(_blocks(analysis)))


KIND = ResultKind(_sections, values=rows_of("goodness", "excluded"))
