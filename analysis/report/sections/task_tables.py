"""Tables of tasks that are told as they stand: settings and exponents of participants, worths, sensitivities."""

from collections.abc import Iterator

from ...result import Analysis
from ..choice_text import choice_table
from ..grid import TextGrid, grid
from ..section import Details, Kind, Lead, Section, Table, TextTable, rows_of

OF_PARTICIPANTS = ("adjustment", "magnitude")
"""Their means stand in the sections of dependent values."""
PREFERENCES = (
    "Bradley-Terry worths (logarithms of odds, mean 0) with 95 % intervals; below them what the first of a pair gains."
)
SENSITIVITIES = "d' per participant, condition and level under the differencing and the independent-observation rule."
TOLD = {"preference": ("Preferences", PREFERENCES), "same_different": ("Same or different", SENSITIVITIES)}
IN_TERMINAL = {
    "preference": "preference (Bradley-Terry worths, 95 % interval)",
    "same_different": "same or different (d′ by either rule)",
}


def _grid(found: Analysis, name: str) -> TextGrid:
    return grid(choice_table(found.tables[name], name, found.trials, found.unit), found.trials.factors)


def _sections(found: Analysis) -> Iterator[Section]:
    for name in OF_PARTICIPANTS:
        if name in found.tables:
            rows = _grid(found, name)
            yield Section("", (Details(f"Participants: {name} ({len(rows.rows)} rows)", (Table(rows),)),))
    for name, (title, lead) in TOLD.items():
        if name in found.tables:
            yield Section(title, (Lead(lead), Table(_grid(found, name))))


def _terminal(found: Analysis) -> Iterator[TextTable]:
    for name, title in IN_TERMINAL.items():
        if name in found.tables:
            yield TextTable(choice_table(found.tables[name], name, found.trials, found.unit), title)


TASK_TABLES = Kind(_sections, _terminal, rows_of("same_different", "preference", *OF_PARTICIPANTS))
