"""From trials to estimates, figures and reports.

The whole way is `analyse` and `write_report`; what `tactometry analyse` does beside them is in `docs/analysis.md`. The
functions below are its steps, each to be had alone: read a table, fit thresholds, compare conditions. A function that
bears the name of its module is imported from there: `mixed_model.mixed_model`, `mixed_anova.mixed_anova`,
`censored_model.censored_model`, `equivalence.equivalence`, `group_pairs.group_pairs`, `bradley_terry.bradley_terry`,
`ratings.ratings`.

A name is imported when it is first asked for.
"""

from typing import TYPE_CHECKING

from tactometry.loading import exports

if TYPE_CHECKING:
    from .anova.nonparametric import aligned_rank_transform, art_contrasts, friedman
    from .anova.post_hoc import pairs, rank_pairs
    from .anova.within_subjects import permutation_test, repeated_measures
    from .attrakdiff.scoring import item_scores, scores
    from .hierarchical.fitting import fit_hierarchical
    from .mixed_models.glmm import fit_glmm
    from .outcomes.group_means import group_table, mean_with_interval
    from .pipeline import Analysis, analyse
    from .plan import Plan, read_plan
    from .reading.column_map import ColumnMap, read_column_map
    from .reading.trials import Trials, read_trials
    from .report.page import write_report
    from .tasks.same_different import differencing_sensitivity, independent_sensitivity
    from .tasks.signal_detection import (
        Sensitivity,
        forced_choice_chance,
        forced_choice_sensitivity,
        two_interval_sensitivity,
        yes_no_sensitivity,
    )
    from .threshold.fitting import ThresholdFit, fit, fit_many
    from .threshold.status import Status

__all__ = [
    "Analysis",
    "ColumnMap",
    "Plan",
    "Sensitivity",
    "Status",
    "ThresholdFit",
    "Trials",
    "aligned_rank_transform",
    "analyse",
    "art_contrasts",
    "differencing_sensitivity",
    "fit",
    "fit_glmm",
    "fit_hierarchical",
    "fit_many",
    "forced_choice_chance",
    "forced_choice_sensitivity",
    "friedman",
    "group_table",
    "independent_sensitivity",
    "item_scores",
    "mean_with_interval",
    "pairs",
    "permutation_test",
    "rank_pairs",
    "read_column_map",
    "read_plan",
    "read_trials",
    "repeated_measures",
    "scores",
    "two_interval_sensitivity",
    "write_report",
    "yes_no_sensitivity",
]

_NAMES = {
    "anova.within_subjects": "permutation_test repeated_measures",
    "attrakdiff.scoring": "item_scores scores",
    "reading.column_map": "ColumnMap read_column_map",
    "tasks.signal_detection": "Sensitivity forced_choice_chance forced_choice_sensitivity two_interval_sensitivity "
    "yes_no_sensitivity",
    "mixed_models.glmm": "fit_glmm",
    "outcomes.group_means": "group_table mean_with_interval",
    "hierarchical.fitting": "fit_hierarchical",
    "anova.nonparametric": "aligned_rank_transform art_contrasts friedman",
    "pipeline": "Analysis analyse",
    "plan": "Plan read_plan",
    "anova.post_hoc": "pairs rank_pairs",
    "report.page": "write_report",
    "tasks.same_different": "differencing_sensitivity independent_sensitivity",
    "threshold.status": "Status",
    "reading.trials": "Trials read_trials",
    "threshold.fitting": "ThresholdFit fit fit_many",
}
__getattr__, __dir__ = exports(__name__, _NAMES)
