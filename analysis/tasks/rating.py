"""Ratings by a questionnaire, which are scored by its own rules (`attrakdiff.scoring`)."""

from .task_analysis import R_OF_FORM, TaskAnalysis

ANALYSIS = TaskAnalysis("Participants felt the stimulus, then filled in a questionnaire", R_OF_FORM)
