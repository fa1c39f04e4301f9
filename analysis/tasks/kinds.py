"""Analyses of the tasks by task name, which is the name of the file."""

from collections.abc import Mapping

from tactometry.loading import resolve
from tactometry.trials.tasks import TASKS

from .task_analysis import Curve, Results, TaskAnalysis

ANALYSES: Mapping[str, TaskAnalysis] = {name: resolve(f"{__package__}.{name}:ANALYSIS") for name in TASKS}
CURVES: Mapping[str, Curve] = {name: found.curve for name, found in ANALYSES.items() if found.curve is not None}
"""Tasks to which a psychometric function is fitted."""
RESULTS: Mapping[str, Results] = {name: found.results for name, found in ANALYSES.items() if found.results is not None}
"""Tasks with other results."""
