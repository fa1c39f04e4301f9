"""Ratings by questionnaire; `attrakdiff.scoring` scores the answers."""

from .task_analysis import R_OF_FORM, TaskAnalysis

ANALYSIS = TaskAnalysis("Participants felt the stimulus, then filled in a questionnaire", R_OF_FORM)
