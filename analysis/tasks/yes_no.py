"""Yes/no detection: threshold, with guess rate from catch trials."""

from .task_analysis import R_OF_LEVEL, Curve, TaskAnalysis, detection

ANALYSIS = TaskAnalysis(
    "Participants reported whether they felt a stimulus",
    R_OF_LEVEL,
    Curve(
        "Rate of “yes”",
        "yes",
        lambda n_choices, unit: detection(unit, None),
        counts_catch=True,
        methods="For yes/no answers, the lapse rate and the guess rate were free (prior Beta(1, 10) for both); "
        "catch trials inform the guess rate.",
        estimate="mode",
    ),
)
