"""What was found in one data set: a value."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import pandas as pd

from .outcomes.findings import Outcome
from .outcomes.hierarchical_outcome import HierarchicalOutcome
from .outcomes.ratings import Ratings
from .plan import AnalysisPlan
from .reading.origin import Origin
from .reading.study_file import StudyText
from .reading.trials import Trials
from .tasks.cell import Estimate


@dataclass(frozen=True)
class Analysis:
    """What was found in one data set.

    `tables` maps a name to the table that is written as NAME.csv; `n_choices` are the alternatives of a forced choice.
    `report` and `tables_folder` are None until written."""

    trials: Trials
    unit: str
    estimates: tuple[Estimate, ...]
    outcomes: tuple[Outcome, ...]
    tables: Mapping[str, pd.DataFrame]
    n_choices: int = 2
    warnings: tuple[str, ...] = ()
    methods: str = ""
    hierarchical: tuple[HierarchicalOutcome, ...] = ()
    forms: tuple[Ratings, ...] = ()
    plan: AnalysisPlan = field(default_factory=AnalysisPlan)
    origin: Origin = field(default_factory=Origin)
    study: StudyText = field(default_factory=StudyText)
    report: Path | None = None
    tables_folder: Path | None = None
    figures_folder: Path | None = None

    @property
    def factors(self) -> tuple[str, ...]:
        """The names of the conditions."""
        return self.trials.factors

    def stem(self, outcome: Outcome) -> str:
        """What the files of an outcome are called: by its dependent value, and by the task too where several have
        any."""
        several = len({other.task for other in self.outcomes}) > 1
        return f"{outcome.task}_{outcome.dependent}" if several else outcome.dependent

    def table(self, name: str) -> pd.DataFrame:
        """One of the tables; an empty one where it has no rows."""
        return self.tables.get(name, pd.DataFrame())
