"""Result of the analysis of one data set."""

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
from .reading.origin import Origin, StudyText
from .reading.trials import Trials
from .tasks.cell import Estimate
from .tasks.cells import CHOICES

SHOWN_ROWS: Final = 20
LAST_SHOWN: Final = ("quality", "excluded", "sittings", "happenings")
"""Tables about the data, shown after the estimates in notebooks."""


@dataclass(frozen=True)
class Analysis:
    """Result of one data set.

    `tables` maps each name to the table that is written as NAME.csv. `report`, `pdf` and `tables_folder` are None until
    they are written.
    """

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
        return self.trials.factors

    @property
    def n_participants(self) -> int:
        return int(self.trials.rows["participant"].nunique())

    @property
    def n_choices(self) -> dict[int, list[tuple[float | str, ...]]]:
        """Conditions of forced choices, by number of alternatives."""
        cells = [estimate.cell for estimate in self.estimates if estimate.cell.task in CHOICES]
        conditions: dict[int, list[tuple[float | str, ...]]] = {cell.n_choices: [] for cell in cells}
        for number, condition in dict.fromkeys((cell.n_choices, cell.condition) for cell in cells):
            conditions[number].append(condition)
        return dict(sorted(conditions.items()))

    def __repr__(self) -> str:
        """Summarise trials, participants, warnings and tables in one line."""
        n_trials, of_whom = count_of(len(self.trials.rows), "trial"), count_of(self.n_participants, "participant")
        return f"Analysis({n_trials} of {of_whom}, {count_of(len(self.warnings), 'warning')}; {', '.join(self.tables)})"

    def _repr_html_(self) -> str:
        """Return warnings and tables as HTML for a notebook."""
        warnings = "".join(f"<li>{escape(warning)}</li>" for warning in self.warnings)
        tables = (
            f"<details{'' if n else ' open'}><summary>{escape(name)} ({count_of(len(table), 'row')})</summary>"
            f"{_as_html(table)}</details>"
            for n, (name, table) in enumerate(sorted(self.tables.items(), key=lambda item: item[0] in LAST_SHOWN))
        )
        return f"<p>{escape(repr(self))}</p><ul>{warnings}</ul>{''.join(tables)}"

    def stem(self, outcome: Outcome) -> str:
        """Return the file name of an outcome, with its task if needed."""
        several = len({other.task for other in self.outcomes}) > 1
        return f"{outcome.task}_{outcome.dependent}" if several else outcome.dependent

    def table(self, name: str) -> pd.DataFrame:
        """Return a table by name, or an empty table."""
        return self.tables.get(name, pd.DataFrame())


def _as_html(table: pd.DataFrame) -> str:
    text = table.to_html(index=False, max_rows=SHOWN_ROWS, na_rep="", float_format="{:.4g}".format, border=0)
    return f'<div style="overflow-x: auto; white-space: nowrap">{text}</div>'
