"""Yes/no detection: a threshold, whose guess rate the catch trials tell."""

from .task_analysis import R_OF_LEVEL, Curve, TaskAnalysis, detection

ANALYSIS = TaskAnalysis(
    "Participants told whether they felt a stimulus",
    R_OF_LEVEL,
    Curve(
        "Rate of “yes”",
        "yes",
        lambda n_choices, unit: detection(unit, None),
        counts_catch=True,
        methods="The guess rate of yes/no answers was free (Beta(1, 10)) and bound by the catch trials.",
    ),
)
