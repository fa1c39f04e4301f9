"""The up-down staircases, transformed and weighted."""

import math
from abc import abstractmethod
from dataclasses import dataclass, field, replace
from statistics import fmean, stdev
from typing import Self

import numpy as np

from tactometry.arguments.require import below, expect, finite, numbers, some, whole

from .procedure import Ending, Rule, RuleThreshold, Run

UP, STAY, DOWN = 1, 0, -1


class UpDown(Rule["StaircaseRun"]):
    """What the transformed and the weighted staircase share: everything but the sizes of their steps."""

    start: float
    n_up: int
    n_down: int
    n_reversals: int
    n_at_bound: int
    initial_rule: bool

    @abstractmethod
    def step(self, direction: int, n_reversals: int) -> float:
        """The size of a step `UP` or `DOWN` after so many reversals."""

    @property
    @abstractmethod
    def point(self) -> str:
        """At which level it settles, in words."""

    def begin(self, rng: np.random.Generator | None = None) -> "StaircaseRun":
        del rng
        return StaircaseRun(self, asked=self.start)

    def _check(self, **schedules: tuple[float, ...]) -> None:
        """Refuse bounds, a start, counts or schedules of steps that make no staircase."""
        owner = type(self).__name__
        finite(owner, start=self.start, low=self.low, high=self.high)
        for name, steps in schedules.items():
            numbers(f"{owner}.{name}", steps)
        counts = {"n_up": self.n_up, "n_down": self.n_down, "n_reversals": self.n_reversals}
        whole(owner, lowest=1, **counts, n_trials=self.n_trials, n_at_bound=self.n_at_bound)
        below(owner, low=self.low, high=self.high)
        among = f"a level between low ({self.low:g}) and high ({self.high:g})"
        expect(self.low <= self.start <= self.high, f"{owner}.start", f"{self.start:g}", among)
        for name, steps in schedules.items():
            _check_steps(f"{owner}.{name}", steps, self.high - self.low)


def _check_steps(where: str, steps: tuple[float, ...], widest: float) -> None:
    some(where, steps)
    for n, step in enumerate(steps):
        expected = f"above 0 and at most the range of levels ({widest:g})"
        expect(0 < step <= widest, f"{where}[{n}]", f"{step:g}", expected)


@dataclass(frozen=True)
class Staircase(UpDown):
    """n-up m-down: `n_down` correct responses in a row lower the level, `n_up` wrong ones in a row raise it.

    The target of 1 up, m down is the level of p = 0.5^(1/m) correct (Levitt, J. Acoust. Soc. Am. 49, 467, 1971, table
    I). Levels are in a unit in which equal steps make sense, such as decibels. Until the first reversal one response
    moves the level (`initial_rule`), as in PsychoPy. Step k is used after k reversals, the last one from then on.

    Differences from PsychoPy's StairHandler: the next level starts from the level that was *delivered*; it ends at
    `n_reversals` reversals or `n_trials` trials, whichever comes first (PsychoPy: when both are reached); and
    `n_at_bound` moves in a row that ask for a level beyond `low` or `high` end it as censored (PsychoPy goes on).

    Raises
    ------
    InvalidParameter
        If bounds, start, steps or counts make no staircase.

    >>> rule = Staircase(start=20.0, steps=(4.0, 2.0), low=0.0, high=40.0, n_down=2, n_reversals=4, n_trials=50)
    >>> rule.after(1).level, rule.after(1).after(0).level
    (16.0, 18.0)
    """

    start: float
    steps: tuple[float, ...]
    low: float
    high: float
    n_up: int = 1
    n_down: int = 2
    n_reversals: int = 8
    n_trials: int = 60
    n_at_bound: int = 3
    initial_rule: bool = True

    name = "staircase"

    def __post_init__(self) -> None:
        self._check(steps=self.steps)

    def step(self, direction: int, n_reversals: int) -> float:
        del direction
        return self.steps[min(n_reversals, len(self.steps) - 1)]

    @property
    def point(self) -> str:
        return f"of {self.n_up} up, {self.n_down} down"


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


@dataclass(frozen=True)
class StaircaseRun(Run[UpDown]):
    """A staircase on its way.

    Parameters
    ----------
    asked : float
        The next level.
    reversals : tuple of float
        The levels at which it turned round.
    direction : int
        Of the last move: `UP`, `DOWN`, or `STAY` before the first.
    streak : int
        Responses in a row of one kind since the last move: above 0 correct, below 0 wrong.
    n_pinned : int
        Moves in a row that asked for a level beyond a bound.
    """

    asked: float = field(kw_only=True)
    reversals: tuple[float, ...] = ()
    direction: int = STAY
    streak: int = 0
    n_pinned: int = 0

    @property
    def level(self) -> float:
        return self.asked

    @property
    def ending(self) -> Ending | None:
        if self.n_pinned >= self.rule.n_at_bound:
            return "censored_above" if self.direction == UP else "censored_below"
        if len(self.reversals) >= self.rule.n_reversals:
            return "converged"
        return "trials" if len(self.responses) >= self.rule.n_trials else None

    def mean_of_reversals(self, *, discard: int = 2) -> float | None:
        """The mean level of the reversals without the first `discard`, made even in number; None if there are fewer
        than two of them or the run is censored."""
        kept = self._late_reversals(discard)
        censored = self.ending in ("censored_above", "censored_below")
        return None if censored or len(kept) < 2 else fmean(kept)

    def _late_reversals(self, discard: int = 2) -> tuple[float, ...]:
        return self.reversals[discard + (len(self.reversals) - discard) % 2 :]  # as many peaks as valleys

    def _estimate(self) -> RuleThreshold:
        """`mean_of_reversals` without the first two."""
        kept = self._late_reversals()
        if len(kept) < 2:
            return RuleThreshold(note=f"too few reversals: {len(self.reversals)} {self.rule.point}")
        return RuleThreshold(fmean(kept), stdev(kept), len(kept), f"mean of reversals {self.rule.point}")

    def _updated(self) -> Self:
        correct, level = bool(self.responses[-1]), self.delivered[-1]
        same = self.streak > 0 if correct else self.streak < 0
        streak = (self.streak if same else 0) + (1 if correct else -1)
        direction = self._direction_after(streak)
        if direction == STAY:
            return replace(self, streak=streak, asked=self._clip(level))
        return self._move(level, direction)

    def _direction_after(self, streak: int) -> int:
        first = self.rule.initial_rule and not self.reversals
        if streak >= (1 if first else self.rule.n_down):
            return DOWN
        return UP if -streak >= (1 if first else self.rule.n_up) else STAY

    def _move(self, level: float, direction: int) -> Self:
        """A step from the level that was delivered; it counts as pinned if a bound stood there already."""
        turned = self.direction == -direction  # never at the first move, whose predecessor is STAY
        reversals = (*self.reversals, level) if turned else self.reversals
        pinned = level >= self.rule.high if direction == UP else level <= self.rule.low
        return replace(
            self,
            asked=self._clip(level + direction * self.rule.step(direction, len(reversals))),
            reversals=reversals,
            direction=direction,
            streak=0,
            n_pinned=self.n_pinned + 1 if pinned and not turned else int(pinned),
        )

    def _clip(self, level: float) -> float:
        return min(max(level, self.rule.low), self.rule.high)
