"""Forced choice: threshold with a guess rate of 1 / number of intervals."""

from .task_analysis import Curve, TaskAnalysis, detection

ANALYSIS = TaskAnalysis(
    "Participants reported which interval contained the stimulus",
    "lme4::glmer(correct ~ level{times} + (1 | participant), {data}, binomial(psyphy::mafc.probit({n_choices})))",
    Curve(
        "Rate correct",
        "correct",
        lambda n_choices, unit: detection(unit, 1 / n_choices),
        scored_by="correct",
        methods="For forced choices, the guess rate was {guess_rate} and the lapse rate was free (prior Beta(1, 20)).",
    ),
)
