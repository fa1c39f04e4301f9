"""Forced choice: a threshold with guess rate 1 / number of intervals."""

from .task_analysis import Curve, TaskAnalysis, detection

ANALYSIS = TaskAnalysis(
    "Participants reported in which interval the stimulus was",
    "lme4::glmer(correct ~ level{times} + (1 | participant), {data}, binomial(psyphy::mafc.probit({n_choices})))",
    Curve(
        "Rate correct",
        "correct",
        lambda n_choices, unit: detection(unit, 1 / n_choices),
        scored_by="correct",
        methods="The guess rate of forced choices was {guess_rate}, and their lapse rate free (Beta(1, 20)).",
    ),
)
