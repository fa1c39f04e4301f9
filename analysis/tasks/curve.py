"""The psychometric function of a task: what its answers count as, and what of the function is known beforehand."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

from scipy.special import ndtri

from tactometry.psychometric import SHAPES

from ..reading.level_scale import is_logarithm

SHAPE = "normal"
DETECTION_SHAPE_IN_DB = "gumbel"
JND_PER_SD = float(ndtri(0.75))
"""The just noticeable difference over the standard deviation of the normal function: 0.6745."""
DIFFERENCE_PER_WIDTH = JND_PER_SD / SHAPES[SHAPE].z_width


@dataclass(frozen=True)
class Curve:
    """How the answers of a task follow its levels.

    Parameters
    ----------
    rate_label : str
        What the rate of successes is called on an axis.
    success : str
        What a success is called in a caption.
    options : callable
        From the number of alternatives and the unit of the levels to options of the fit.
    scored_by : str
        The column that says whether a trial was a success, 1 or 0.
    has_difference : bool
        The threshold is a point of subjective equality, and the width a just noticeable difference.
    counts_catch : bool
        Answers in catch trials tell the guess rate.
    methods : str
        What the methods section says of the rates, with ``{n_choices}``.
    """

    rate_label: str
    success: str
    options: Callable[[int, str], Mapping[str, Any]]
    scored_by: Literal["response", "correct"] = "response"
    has_difference: bool = False
    counts_catch: bool = False
    methods: str = ""

    @property
    def dependents(self) -> tuple[str, ...]:
        """The values of each participant and condition that are compared."""
        return ("pse", "jnd") if self.has_difference else ("threshold",)


def shape_of(unit: str) -> str:
    """The psychometric function of detection: Weibull's of the amplitude, which is a Gumbel in decibels
    (Watson 1979, Vision Res. 19, 515), where levels are logarithms; else the cumulative normal."""
    return DETECTION_SHAPE_IN_DB if is_logarithm(unit) else SHAPE


def detection(unit: str, guess_rate: float | None) -> Mapping[str, Any]:
    """Options of the fit to a detection: a guess rate of None is free."""
    return {"shape": shape_of(unit), "guess_rate": guess_rate, "scale_free_width": True}
