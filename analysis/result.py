"""What was found in one data set: a value."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from typing import Final

import pandas as pd

from tactometry.errors import count_of

from .outcomes.findings import Outcome
from .outcomes.hierarchical_outcome import HierarchicalOutcome
from .outcomes.ratings import Ratings
from .plan import AnalysisPlan
from .reading.origin import Origin
from .reading.study_file import StudyText
from .reading.trials import Trials
from .tasks.cell import Estimate
from .tasks.cells import CHOICES

SHOWN_ROWS: Final = 20
LAST_SHOWN: Final = ("quality", "excluded", "sittings", "happenings")
"""Tables of how the data came about, which a notebook shows behind what was estimated."""


@dataclass(frozen=True)
class Analysis:
    """What was found in one data set.

    `tables` maps a name to the table that is written as NAME.csv.
    `report`, `pdf` and `tables_folder` are None until written."""

    trials: Trials
    unit: str
    estimates: tuple[Estimate, ...]
    outcomes: tuple[Outcome, ...]
    tables: Mapping[str, pd.DataFrame]
    warnings: tuple[str, ...] = ()
    methods: str = ""
    hierarchical: tuple[HierarchicalOutcome, ...] = ()
    forms: tuple[Ratings, ...] = ()
    plan: AnalysisPlan = field(default_factory=AnalysisPlan)
    origin: Origin = field(default_factory=Origin)
    study: StudyText = field(default_factory=StudyText)
    report: Path | None = None
    pdf: Path | None = None
    tables_folder: Path | None = None
    figures_folder: Path | None = None

    @property
    def factors(self) -> tuple[str, ...]:
        """The names of the conditions."""
        return self.trials.factors

    @property
    def n_choices(self) -> dict[int, list[tuple[float | str, ...]]]:
        """Each number of alternatives of the forced choices, with the conditions that have it."""
        found: dict[int, list[tuple[float | str, ...]]] = {}
        for cell in (estimate.cell for estimate in self.estimates if estimate.cell.task in CHOICES):
            conditions = found.setdefault(cell.n_choices, [])
            conditions += [] if cell.condition in conditions else [cell.condition]
        return dict(sorted(found.items()))

    def __repr__(self) -> str:
        """In one line: what was analysed, and which tables there are."""
        participants = self.trials.rows["participant"].nunique()
        n_trials, of_whom = count_of(len(self.trials.rows), "trial"), count_of(participants, "participant")
        return f"Analysis({n_trials} of {of_whom}, {count_of(len(self.warnings), 'warning')}; {', '.join(self.tables)})"

    def _repr_html_(self) -> str:
        """What a notebook shows: the warnings, and each table behind its name, the first of them open."""
        warnings = "".join(f"<li>{escape(warning)}</li>" for warning in self.warnings)
        tables = (
            f"<details{'' if n else ' open'}><summary>{escape(name)} ({count_of(len(table), 'row')})</summary>"
            f"{_as_html(table)}</details>"
            for n, (name, table) in enumerate(self._estimates_first())
        )
        return f"<p>{escape(repr(self))}</p><ul>{warnings}</ul>{''.join(tables)}"

    def _estimates_first(self) -> list[tuple[str, pd.DataFrame]]:
        return sorted(self.tables.items(), key=lambda item: item[0] in LAST_SHOWN)

    def stem(self, outcome: Outcome) -> str:
        """What the files of an outcome are called: by its dependent value, and by the task too where several have
        any."""
        several = len({other.task for other in self.outcomes}) > 1
        return f"{outcome.task}_{outcome.dependent}" if several else outcome.dependent

    def table(self, name: str) -> pd.DataFrame:
        """One of the tables; an empty one where it has no rows."""
        return self.tables.get(name, pd.DataFrame())


def _as_html(table: pd.DataFrame) -> str:
    text = table.to_html(index=False, max_rows=SHOWN_ROWS, na_rep="", float_format="{:.4g}".format, border=0)
    return f'<div style="overflow-x: auto; white-space: nowrap">{text}</div>'
