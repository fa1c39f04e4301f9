"""What is delivered of a level that is asked for, as an output's resolution and range allow it."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from tactometry.arguments.require import expect, finite, not_negative

from .answers import Array


def nearest(level: Any, step: float, low: float, high: float) -> Any:
    """A level, or an array of them, at its nearest whole step (none: 0) and within bounds; numba knows all of it."""
    stepped = step * np.rint(level / step) if step > 0 else level
    return np.minimum(np.maximum(stepped, low), high)


@dataclass(frozen=True)
class Delivery:
    """An output that delivers whole steps of a level, within bounds. Answers are given to what is delivered, and the
    rule is told it, as in a session.

    Parameters
    ----------
    step : float
        In the unit of the level; 0 delivers every level.
    low, high : float
        The least and the greatest that it delivers.

    Raises
    ------
    InvalidParameter
        If the step is below 0, or the bounds are no numbers in order.

    >>> Delivery(step=0.5, high=30.0)(np.array([12.3, 31.0])).tolist()
    [12.5, 30.0]
    """

    step: float = 0.0
    low: float = -math.inf
    high: float = math.inf

    def __post_init__(self) -> None:
        finite("Delivery", step=self.step)
        not_negative("Delivery", step=self.step)
        expect(self.low <= self.high, "Delivery.low", f"{self.low:g}", f"at most high, {self.high:g}")

    @property
    def numbers(self) -> tuple[float, float, float]:
        """As `nearest` takes them."""
        return float(self.step), float(self.low), float(self.high)

    def __call__(self, levels: Array) -> Array:
        """What is delivered of levels."""
        return np.asarray(nearest(levels, *self.numbers))


AS_ASKED = Delivery()
