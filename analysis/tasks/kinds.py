"""Analyses of the tasks, by task name (the name of the file)."""

from collections.abc import Mapping

from tactometry.loading import resolve
from tactometry.trials.tasks import TASKS

from .task_analysis import Curve, Results, TaskAnalysis

ANALYSES: Mapping[str, TaskAnalysis] = {name: resolve(f"{__package__}.{name}:ANALYSIS") for name in TASKS}
CURVES: Mapping[str, Curve] = {name: found.curve for name, found in ANALYSES.items() if found.curve is not None}
"""The tasks that a psychometric function is fitted to."""
RESULTS: Mapping[str, Results] = {name: found.results for name, found in ANALYSES.items() if found.results is not None}
"""The tasks with results of another kind."""
