"""Localisation: exported, and counted as not analysed here."""

from .task_analysis import TaskAnalysis

ANALYSIS = TaskAnalysis(
    "Participants told which of the alternatives it was",
    'lme4::glmer(correct ~ {plus} + (1 | participant), {data}, binomial("probit"))',
)
