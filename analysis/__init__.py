"""Estimates, figures and reports computed from trials.

`analyse` runs the whole analysis; the other functions are its steps. `docs/reference/analysis.md` lists further
functions.
"""

from typing import TYPE_CHECKING

from tactometry.loading import exports

if TYPE_CHECKING:
    from .anova.group_means import group_table as group_table
    from .anova.post_hoc import pairs as pairs
    from .anova.within_subjects import repeated_measures as repeated_measures
    from .attrakdiff.scoring import scores as scores
    from .hierarchical.fitting import fit_hierarchical as fit_hierarchical
    from .hierarchical.result import HierarchicalFit as HierarchicalFit
    from .pipeline import analyse as analyse
    from .reading.column_map import ColumnMap as ColumnMap, read_column_map as read_column_map
    from .reading.trials import Trials as Trials, read_trials as read_trials
    from .report.page import write_report as write_report
    from .result import Analysis as Analysis
    from .tasks.signal_detection import (
        forced_choice_sensitivity as forced_choice_sensitivity,
        yes_no_sensitivity as yes_no_sensitivity,
    )
    from .threshold.fitting import ThresholdFit as ThresholdFit, fit as fit, fit_many as fit_many
    from .threshold.status import Status as Status

__getattr__, __dir__ = exports(__name__, __file__)
