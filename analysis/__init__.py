"""Estimates, figures and reports of trials.

`analyse` does all of it; the other functions are its steps. `docs/reference/analysis.md` lists more.
"""

from typing import TYPE_CHECKING

from tactometry.loading import exports

if TYPE_CHECKING:
    from .anova.group_means import group_table as group_table
    from .anova.post_hoc import pairs as pairs
    from .anova.within_subjects import permutation_test as permutation_test, repeated_measures as repeated_measures
    from .attrakdiff.scoring import item_scores as item_scores, scores as scores
    from .hierarchical.fitting import fit_hierarchical as fit_hierarchical
    from .means import mean_with_interval as mean_with_interval
    from .pipeline import analyse as analyse
    from .plan import AnalysisPlan as AnalysisPlan, read_plan as read_plan
    from .reading.column_map import ColumnMap as ColumnMap, read_column_map as read_column_map
    from .reading.trials import Trials as Trials, read_trials as read_trials
    from .report.page import write_report as write_report
    from .result import Analysis as Analysis
    from .tasks.same_different import (
        differencing_sensitivity as differencing_sensitivity,
        independent_sensitivity as independent_sensitivity,
    )
    from .tasks.signal_detection import (
        SensitivityIndex as SensitivityIndex,
        forced_choice_chance as forced_choice_chance,
        forced_choice_sensitivity as forced_choice_sensitivity,
        yes_no_sensitivity as yes_no_sensitivity,
    )
    from .threshold.fitting import ThresholdFit as ThresholdFit, fit as fit, fit_many as fit_many
    from .threshold.status import Status as Status

__getattr__, __dir__ = exports(__name__, __file__)
