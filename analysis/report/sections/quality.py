"""Quality of the data: what was recorded and used, goodness of fit, and what a plan left out."""

from collections.abc import Iterator

from ...result import Analysis
from ..grid import grid
from ..section import Block, Heading, Kind, Lead, Section, TableBlock, rows_of

COLUMNS = {
    "n_rows": "rows", "n_practice": "practice", "n_invalid": "invalid", "n_repeated": "asked again",
    "n_unanswered": "unanswered", "n_catch": "catch trials", "n_false_alarms": "false alarms",
    "false_alarm_rate": "rate of false alarms", "n_frames": "frames", "n_dropped_frames": "dropped frames",
    "n_tested": "functions", "n_flagged": "with p ≤ .01", "n_by_chance": "by chance", "meaning": "what a small p says",
}  # fmt: skip
"""Columns of the tables of data quality and of goodness of fit, in words."""
GOODNESS = (
    "Tests of the fitted functions with p ≤ .01, and how many chance alone would flag. Which functions: column misfit "
    "of thresholds.csv."
)


def _table(found: Analysis, name: str) -> TableBlock:
    return TableBlock(grid(found.tables[name].rename(columns=COLUMNS), found.trials.factors))


def _blocks(found: Analysis) -> Iterator[Block]:
    yield _table(found, "quality")
    if "goodness" in found.tables:
        yield from (Heading("Goodness of fit"), Lead(GOODNESS), _table(found, "goodness"))
    if "excluded" in found.tables:
        yield from (Heading("Left out by the plan of analysis"), _table(found, "excluded"))


def _sections(found: Analysis) -> Iterator[Section]:
    yield Section("Data quality", tuple(_blocks(found)))


QUALITY = Kind(_sections, values=rows_of("goodness", "excluded"))
