"""Tables of tasks without a curve: a section of its own, or below those of the dependent values that are its means."""

from collections.abc import Iterator

import pandas as pd

from ...result import Analysis
from ...tasks.kinds import RESULTS
from ..grid import grid
from ..section import Details, Kind, Lead, Section, TableBlock, TextTable, rows_of

TOLD = {task: results for task, results in RESULTS.items() if results.title or results.dependent}


def _views(found: Analysis) -> Iterator[tuple[str, pd.DataFrame]]:
    """Each task with its table as a person reads it; a column of notes only where there are any."""
    for task in (task for task in TOLD if task in found.tables):
        table = TOLD[task].view(found.tables[task], found.trials, found.unit)
        is_noted = "note" in table.columns and (table["note"] != "").any()
        yield task, table if is_noted else table.drop(columns="note", errors="ignore")


def _sections(found: Analysis) -> Iterator[Section]:
    views = {task: grid(view, found.trials.factors) for task, view in _views(found)}
    for task, view in views.items():
        if TOLD[task].dependent:
            yield Section("", (Details(f"Participants: {task} ({len(view.rows)} rows)", (TableBlock(view),)),))
    for task, view in views.items():
        if TOLD[task].title:
            yield Section(TOLD[task].title, (Lead(TOLD[task].lead), TableBlock(view)))


def _terminal(found: Analysis) -> Iterator[TextTable]:
    for task, view in _views(found):
        if TOLD[task].in_terminal:
            yield TextTable(view, TOLD[task].in_terminal)


TASK_TABLES = Kind(_sections, _terminal, rows_of(*TOLD))
