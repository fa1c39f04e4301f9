"""Data quality: numbers of trials, goodness of fit, and exclusions."""

from collections.abc import Iterator

from ...result import Analysis
from ..section import Content, Heading, Lead, ResultKind, Section, grid, rows_of

COLUMNS = {
    "n_rows": "rows", "n_practice": "practice", "n_invalid": "invalid", "n_repeated": "repeated",
    "n_unanswered": "unanswered", "n_catch": "catch trials", "n_false_alarms": "false alarms",
    "practice_missed": "practice missed",
    "false_alarm_rate": "false-alarm rate", "n_frames": "frames", "n_dropped_frames": "dropped frames",
    "n_tested": "functions", "n_flagged": "with p ≤ .01", "n_by_chance": "by chance", "meaning": "meaning of a small p",
}  # fmt: skip
"""Headings of the tables of data quality and goodness of fit."""
GOODNESS = (
    "Number of fitted functions with p ≤ .01 in each test, and the number expected by chance. The column misfit of "
    "thresholds.csv marks these functions."
)
HEADS: dict[str, tuple[Content, ...]] = {
    "quality": (),
    "goodness": (Heading("Goodness of fit"), Lead(GOODNESS)),
    "excluded": (Heading("Excluded by the analysis plan"),),
}


def _sections(analysis: Analysis) -> Iterator[Section]:
    blocks: list[Content] = []
    for name, head in HEADS.items():
        if name in analysis.tables:
            blocks += [*head, grid(analysis.tables[name].rename(columns=COLUMNS), analysis.factors)]
    yield Section("Data quality", tuple(blocks))


KIND = ResultKind(_sections, values=rows_of("goodness", "excluded"))
