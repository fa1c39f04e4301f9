"""Yes/no detection: a threshold, with the guess rate from catch trials."""

from .task_analysis import R_OF_LEVEL, Curve, TaskAnalysis, detection

ANALYSIS = TaskAnalysis(
    "Participants reported whether they felt a stimulus",
    R_OF_LEVEL,
    Curve(
        "Rate of “yes”",
        "yes",
        lambda n_choices, unit: detection(unit, None),
        counts_catch=True,
        methods="Lapse rate and guess rate of yes/no answers were free (both Beta(1, 10)), "
        "the latter bound by the catch trials.",
        estimate="mode",
    ),
)
