"""Oddity: a threshold, whose guess rate is one third."""

from .task_analysis import Curve, TaskAnalysis, detection

ANALYSIS = TaskAnalysis(
    "Participants reported which of three intervals was the odd one",
    "lme4::glmer(correct ~ level{times} + (1 | participant), {data}, binomial(psyphy::mafc.probit(3)))",
    Curve(
        "Rate correct",
        "correct",
        lambda n_choices, unit: detection(unit, 1 / 3),
        scored_by="correct",
        methods="The guess rate of odd ones was 1/3.",
    ),
)
