"""The weighted up-down staircase."""

import math
from dataclasses import dataclass

from tactometry.arguments.require import expect

from .staircase import UP, UpDown


@dataclass(frozen=True)
class WeightedStaircase(UpDown):
    """Steps up and down of different size: the target is p = (d_up / (d_up + d_down))^(1 / n_down).

    With `n_down` 1 it is Kaernbach's (Perception & Psychophysics 49, 227, 1991), above 1 Garcia-Perez's weighted
    transformed one (Vision Research 38, 1861, 1998). Reversals, bounds and endings are those of `Staircase`.

    Parameters
    ----------
    steps_up, steps_down : tuple of float
        Of equal length; pair k is used after k reversals, the last one from then on.

    Raises
    ------
    InvalidParameter
        If the pairs do not match, or as `Staircase`.

    >>> rule = WeightedStaircase(start=20.0, steps_up=(6.0,), steps_down=(2.0,), low=0.0, high=40.0)
    >>> rule.target, rule.after(1).level, rule.after(0).level
    (0.75, 18.0, 26.0)
    """

    start: float
    steps_up: tuple[float, ...]
    steps_down: tuple[float, ...]
    low: float
    high: float
    n_down: int = 1
    n_reversals: int = 8
    n_trials: int = 60
    n_at_bound: int = 3

    name = "weighted_staircase"
    n_up = 1
    initial_rule = False

    def __post_init__(self) -> None:
        self._check(steps_up=self.steps_up, steps_down=self.steps_down)
        n_up, n_down = len(self.steps_up), len(self.steps_down)
        expect(n_up == n_down, "WeightedStaircase.steps_up", f"{n_up} steps and {n_down} steps_down", "pairs")

    def step(self, direction: int, n_reversals: int) -> float:
        steps = self.steps_up if direction == UP else self.steps_down
        return steps[min(n_reversals, len(steps) - 1)]

    @property
    def target(self) -> float:
        """The probability correct at which up and down balance, with the last pair of steps."""
        up, down = self.steps_up[-1], self.steps_down[-1]
        return math.pow(up / (up + down), 1 / self.n_down)

    @property
    def point(self) -> str:
        return f"at a chance of {self.target:.2f}"
