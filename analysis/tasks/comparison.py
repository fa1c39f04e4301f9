"""Comparison with a standard: PSE and just noticeable difference."""

from collections.abc import Mapping
from typing import Any

from .task_analysis import R_OF_LEVEL, SHAPE, Curve, TaskAnalysis

FIT: Mapping[str, Any] = {
    "shape": SHAPE,
    "guess_rate": None,
    "lapse_beta": 3.0,
    "guess_beta": 3.0,
    "scale_free_width": True,
    "narrowest_spacings": 0.5,
}
"""Options of the fit (unverified defaults).

Both asymptotes are free, as levels that are not felt are sometimes called "more". With such answers, a prior tighter
than Beta(1, 3) biases the point of subjective equality downwards. The prior of the width is flat in its logarithm down
to one spacing of the levels. psignifit's prior decreases below two spacings and biases small differences upwards. The
bias study compares both (`benchmarks/bias_study.py`)."""

ANALYSIS = TaskAnalysis(
    "Participants reported which of a standard and a comparison stimulus was stronger",
    R_OF_LEVEL,
    Curve(
        "Rate of “more”",
        "more",
        lambda n_choices, unit: FIT,
        has_difference=True,
        methods="Points of subjective equality (the level judged stronger than the standard in half of the "
        "trials) and just "
        "noticeable differences (the distance from there to the level judged stronger in 75 % of the trials) are "
        "posterior medians with central 95 % intervals. Both asymptotes of comparisons were free (Beta(1, 3)); the "
        "prior of the width was flat in its logarithm from the smallest spacing of the levels to their range.",
    ),
)
