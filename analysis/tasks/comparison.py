"""Comparison with a standard: a point of subjective equality and a just noticeable difference."""

from collections.abc import Mapping
from typing import Any

from .task_analysis import R_OF_LEVEL, SHAPE, Curve, TaskAnalysis

FIT: Mapping[str, Any] = {
    "shape": SHAPE,
    "guess_rate": None,
    "equal_asymptotes": True,
    "rate_beta": 80.0,
    "scale_free_width": True,
    "narrowest_spacings": 0.5,
}
"""Who lapses in a comparison says either with the same chance: both asymptotes are half of the rate of lapses, whose
mean is 2.5 % under Beta(1, 80). The width, a scale, has a prior flat in its logarithm, from one spacing of the levels
on: psignifit's, which falls below two, holds small differences up. Of the priors tried these cover best between 0 and
5 % lapses (`benchmarks/census_comparisons.py`); unverified defaults."""

ANALYSIS = TaskAnalysis(
    "Participants told which of a standard and a level was stronger",
    R_OF_LEVEL,
    Curve(
        "Rate of “more”",
        "more",
        lambda n_choices, unit: FIT,
        has_difference=True,
        methods="Points of subjective equality and just noticeable differences (0.6745 standard deviations) of "
        "comparisons are posterior modes with central 95 % intervals of the marginal posterior. Both asymptotes were "
        "equally far from 0 and 1 (one rate, Beta(1, 80)), as of lapses that go either way with the same chance; the "
        "prior of the width was flat in its logarithm from the smallest spacing of the levels to their range.",
    ),
)
