"""From trials to estimates, figures and reports.

The whole way is `analyse` and `write_report`; what `tactometry analyse` does beside them is in `docs/analysis.md`. The
functions below are its steps, each to be had alone: read a table, fit thresholds, compare conditions. A function that
bears the name of its module is imported from there: `mixed_model.mixed_model`, `mixed_anova.mixed_anova`,
`censored_model.censored_model`, `equivalence.equivalence`, `group_pairs.group_pairs`, `bradley_terry.bradley_terry`,
`ratings.ratings`.

A name is imported when it is first asked for.
"""

from typing import TYPE_CHECKING

from tactometry.lazy import exports

if TYPE_CHECKING:
    from tactometry.analysis.anova import permutation_test, repeated_measures
    from tactometry.analysis.attrakdiff import item_scores, scores
    from tactometry.analysis.column_map import ColumnMap, read_column_map
    from tactometry.analysis.detection import (
        Sensitivity,
        forced_choice_chance,
        forced_choice_sensitivity,
        two_interval_sensitivity,
        yes_no_sensitivity,
    )
    from tactometry.analysis.glmm import fit_glmm
    from tactometry.analysis.group import group_table, mean_with_interval
    from tactometry.analysis.hierarchical import fit_hierarchical
    from tactometry.analysis.nonparametric import aligned_rank_transform, art_contrasts, friedman
    from tactometry.analysis.pipeline import Analysis, analyse
    from tactometry.analysis.plan import Plan, read_plan
    from tactometry.analysis.post_hoc import pairs, rank_pairs
    from tactometry.analysis.report import write_report
    from tactometry.analysis.same_different import differencing_sensitivity, independent_sensitivity
    from tactometry.analysis.status import Status
    from tactometry.analysis.table import Trials, read_trials
    from tactometry.analysis.threshold import ThresholdFit, fit, fit_many

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
    "anova": "permutation_test repeated_measures",
    "attrakdiff": "item_scores scores",
    "column_map": "ColumnMap read_column_map",
    "detection": "Sensitivity forced_choice_chance forced_choice_sensitivity two_interval_sensitivity "
    "yes_no_sensitivity",
    "glmm": "fit_glmm",
    "group": "group_table mean_with_interval",
    "hierarchical": "fit_hierarchical",
    "nonparametric": "aligned_rank_transform art_contrasts friedman",
    "pipeline": "Analysis analyse",
    "plan": "Plan read_plan",
    "post_hoc": "pairs rank_pairs",
    "report": "write_report",
    "same_different": "differencing_sensitivity independent_sensitivity",
    "status": "Status",
    "table": "Trials read_trials",
    "threshold": "ThresholdFit fit fit_many",
}
__getattr__, __dir__ = exports(__name__, _NAMES)
