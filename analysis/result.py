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
from .reading.study_text import StudyText
from .reading.trials import Trials
from .tasks import cells


@dataclass(frozen=True)
class Analysis:
    """What was found in one data set.

    `tables` maps a name to the table that is written as NAME.csv. `report` and `tables_folder` are None until
    written.
    """

    trials: Trials
    unit: str
    estimates: tuple[cells.Estimate, ...]
    outcomes: tuple[Outcome, ...]
    tables: Mapping[str, pd.DataFrame]
    warnings: tuple[str, ...]
    methods: str
    together: tuple[HierarchicalOutcome, ...] = ()
    forms: tuple[Ratings, ...] = ()
    plan: AnalysisPlan = field(default_factory=AnalysisPlan)
    origin: Origin = field(default_factory=Origin)
    study: StudyText = field(default_factory=StudyText)
    report: Path | None = None
    tables_folder: Path | None = None
    figures_folder: Path | None = None
