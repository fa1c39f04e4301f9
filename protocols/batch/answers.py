"""Levels as delivered and felt, and the criteria above which they are answered with 1.

A psychometric function is a distribution of criteria, so all that is random is drawn before the first trial.
"""

import math
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tactometry.arguments.require import ascending, expect, finite, finite_array, not_negative
from tactometry.psychometric import shape_named

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class LevelTable:
    """What is felt at the levels of a stimulus: a table, straight lines between its places, its ends beyond them.

    Sensation levels through a scene make one such table for a population; or chances of the answer 1, with uniform
    criteria.

    - `levels`: (n_levels,). Rising.
    - `felt`: (n_levels,) or (n_sets, n_levels). Of all sets, or of each.

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
        """Of a part of the sets."""
        return self if len(self.felt) == 1 else type(self)(self.levels, self.felt[sets])

    def at(self, levels: Array, sets: NDArray[np.intp]) -> Array:
        """What each of some sets feels at its level, (n,)."""
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
    """The level above which a trial is answered with 1, of uniform numbers: the inverse of the psychometric function.

    Where a number is below the guess rate any level is, minus infinity; within the lapse rate of 1 no level is.

    - `uniform`: (n_sets, n_trials). In [0, 1).
    - `shape`: As of `tactometry.psychometric.PsychometricFunction`, as are the others: numbers, or arrays (n_sets, 1)
      or (n_sets, n_trials).

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
    """A level, or an array of them, at its nearest whole step (none: 0) and within bounds; numba knows all of it."""
    stepped = step * np.rint(level / step) if step > 0 else level
    return np.minimum(np.maximum(stepped, low), high)


@dataclass(frozen=True)
class Delivery:
    """An output that delivers whole steps of a level, within bounds. Answers are given to what is delivered, and the
    rule is told it, as in a session.

    - `step`: In the unit of the level; 0 delivers every level.
    - `low`, `high`: The least and the greatest that it delivers.

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
