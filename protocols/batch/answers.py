"""Delivered and perceived levels of a batch, and response criteria.

A psychometric function is a distribution of criteria, so all random numbers are drawn before the first trial.
"""

import math
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tactometry.arguments.constraints import NotNegative, constrained
from tactometry.arguments.require import ascending, expect, finite_array
from tactometry.psychometric import shape_named

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class LevelTable:
    """Perceived level, or probability of the answer 1, at increasing levels.

    - `felt`: Shape (n_levels,) for all sets, or (n_sets, n_levels).

    >>> LevelTable(np.array([0.0, 10.0]), np.array([-3.0, 7.0])).felt.shape
    (1, 2)
    """

    levels: Array
    felt: Array

    def __post_init__(self) -> None:
        levels, felt = ascending("LevelTable.levels", self.levels), finite_array("LevelTable.felt", self.felt)
        fits = felt.ndim in (1, 2) and felt.shape[-1] == len(levels)
        expect(fits, "LevelTable.felt", f"the shape {felt.shape}", f"(n_sets, {len(levels)}) or ({len(levels)},)")
        object.__setattr__(self, "levels", levels)
        object.__setattr__(self, "felt", np.atleast_2d(felt))

    def rows(self, sets: slice) -> Self:
        """Return the table of the selected sets."""
        return self if len(self.felt) == 1 else type(self)(self.levels, self.felt[sets])

    def at(self, levels: Array, sets: NDArray[np.intp]) -> Array:
        """Return the perceived level of each set, (n,)."""
        if len(self.felt) == 1:
            return np.asarray(np.interp(levels, self.levels, self.felt[0]))
        pairs = zip(levels.tolist(), self.felt[sets], strict=True)
        return np.array([np.interp(level, self.levels, row) for level, row in pairs])


def criteria(
    uniform: Array,
    shape: str,
    threshold: ArrayLike,
    width: ArrayLike,
    guess_rate: ArrayLike = 0.0,
    lapse_rate: ArrayLike = 0.0,
) -> Array:
    """Return criteria: the inverse psychometric function of uniform numbers.

    A criterion is minus infinity below the guess rate, and infinity within the lapse rate of 1.

    - `uniform`: Uniform numbers, (n_sets, n_trials), in [0, 1).
    - `shape`: Name as in `tactometry.psychometric.PsychometricFunction`; the other arguments are numbers, or arrays
      (n_sets, 1) or (n_sets, n_trials).

    >>> criteria(np.array([[0.1, 0.74, 0.99]]), "normal", 20.0, 8.0, 0.5, 0.02).round(9).tolist()
    [[-inf, 20.0, inf]]
    """
    kind, guess, lapse = shape_named(shape), np.asarray(guess_rate), np.asarray(lapse_rate)
    share = np.clip((uniform - guess) / (1 - guess - lapse), 0.0, 1.0)
    with np.errstate(divide="ignore"):
        z = kind.at(np.log(share), np.log1p(-share))
    away = (z - kind.z50) / kind.z_width * np.asarray(width)
    return np.asarray(np.asarray(threshold) * np.exp(away) if kind.on_log_levels else np.asarray(threshold) + away)


def nearest(level: Any, step: float, low: float, high: float) -> Any:
    """Round levels to whole steps (0: no steps) within bounds, also in numba."""
    stepped = step * np.rint(level / step) if step > 0 else level
    return np.minimum(np.maximum(stepped, low), high)


@dataclass(frozen=True)
@constrained
class Delivery:
    """Output that delivers levels in steps (0: any level) from `low` to `high`.

    >>> Delivery(step=0.5, high=30.0)(np.array([12.3, 31.0])).tolist()
    [12.5, 30.0]
    """

    step: NotNegative = 0.0
    low: float = -math.inf
    high: float = math.inf

    def __post_init__(self) -> None:
        expect(self.low <= self.high, "Delivery.low", f"{self.low:g}", f"at most high, {self.high:g}")

    @property
    def numbers(self) -> tuple[float, float, float]:
        """Step and bounds, as arguments of `nearest`."""
        return float(self.step), float(self.low), float(self.high)

    def __call__(self, levels: Array) -> Array:
        """Return the delivered levels."""
        return np.asarray(nearest(levels, *self.numbers))


AS_ASKED = Delivery()
