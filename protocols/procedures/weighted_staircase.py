"""The weighted up-down staircase."""

import math
from dataclasses import dataclass, replace
from typing import Self

from tactometry.errors import InvalidParameter

from .procedure import Ending, checked_response, refuse_finished
from .staircase import COUNTS, Staircase, check_rule


@dataclass(frozen=True)
class WeightedStaircase:
    """Steps up and down of different size: the target is p = (d_up / (d_up + d_down))^(1 / n_down).

    With `n_down` 1 it is Kaernbach's (Perception & Psychophysics 49, 227, 1991), above 1 Garcia-Perez's weighted
    transformed one (Vision Research 38, 1861, 1998). `state` is a `Staircase` that is given the steps of the
    answer's direction, so that reversals, bounds, schedule and endings are the same.

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
    state: Staircase | None = None

    name = "weighted_staircase"

    def __post_init__(self) -> None:
        if self.state is not None:
            return
        check_rule(self, COUNTS, steps_up=self.steps_up, steps_down=self.steps_down)
        if len(self.steps_up) != len(self.steps_down):
            raise InvalidParameter(
                f"WeightedStaircase.steps_up: found {len(self.steps_up)} steps and {len(self.steps_down)} steps_down, "
                "expected pairs"
            )
        object.__setattr__(self, "state", self._inside())

    def _inside(self) -> Staircase:
        return Staircase(
            self.start,
            self.steps_down,
            self.low,
            self.high,
            n_down=self.n_down,
            n_reversals=self.n_reversals,
            n_trials=self.n_trials,
            n_at_bound=self.n_at_bound,
            initial_rule=False,
        )

    @property
    def _inner(self) -> Staircase:
        assert self.state is not None
        return self.state

    @property
    def target(self) -> float:
        """The probability correct at which up and down balance, with the last pair of steps."""
        up, down = self.steps_up[-1], self.steps_down[-1]
        return math.pow(up / (up + down), 1 / self.n_down)

    @property
    def level(self) -> float:
        return self._inner.level

    @property
    def reversals(self) -> tuple[float, ...]:
        return self._inner.reversals

    @property
    def finished(self) -> bool:
        return self._inner.finished

    @property
    def ended(self) -> Ending | None:
        return self._inner.ended

    @property
    def threshold(self) -> float | None:
        """`mean_of_reversals` without the first two."""
        return self._inner.threshold

    def mean_of_reversals(self, *, discard: int = 2) -> float | None:
        """As `Staircase.mean_of_reversals`."""
        return self._inner.mean_of_reversals(discard=discard)

    def after(self, response: int | bool, delivered: float | None = None) -> Self:
        """The staircase after a response to the level that was delivered (default: the one asked for)."""
        correct = checked_response(response, "WeightedStaircase")
        refuse_finished(finished=self.finished, procedure="WeightedStaircase")
        steps = self.steps_down if correct else self.steps_up
        return replace(self, state=replace(self._inner, steps=steps).after(correct, delivered))
