"""Up-down staircases, transformed and weighted."""

import math
from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import stdev
from typing import NamedTuple

import numpy as np

from tactometry.arguments.constraints import Finite, constrained
from tactometry.arguments.require import below, expect, numbers, some

from .procedure import Count, RuleThreshold
from .stepping import (
    CENSORED_ABOVE,
    CENSORED_BELOW,
    CONVERGED,
    GOES_ON,
    TRIALS,
    Order,
    State,
    SteppingRule,
    SteppingRun,
    Transition,
)

UP, STAY, DOWN = 1, 0, -1
DISCARDED = 2
"""Number of first reversals, with large steps, that the estimate omits."""


class StaircaseNumbers(NamedTuple):
    """Numbers of both staircases."""

    start: float
    low: float
    high: float
    steps_up: tuple[float, ...]
    steps_down: tuple[float, ...]
    n_up: int
    n_down: int
    initial_rule: bool
    n_reversals: int
    n_trials: int
    n_at_bound: int


# state: requested level, direction of the last move, streak, reversals, consecutive moves beyond a bound
def _start(numbers: StaircaseNumbers, order: Order) -> State:
    return numbers.start, STAY, 0, 0, 0


def _level(numbers: StaircaseNumbers, order: Order, state: State) -> float:
    requested: float = state[0]
    return requested


def _after(
    numbers: StaircaseNumbers, order: Order, state: State, answers: Sequence[int], levels: Sequence[float]
) -> tuple[State, float]:
    """Step from the delivered level; mark reversals and steps beyond a bound."""
    low, high = numbers.low, numbers.high
    _, last, streak, n_reversals, n_pinned = state
    level = levels[-1]
    streak = max(streak, 0) + 1 if answers[-1] else min(streak, 0) - 1

    is_first = numbers.initial_rule and n_reversals == 0
    down = streak >= (1 if is_first else numbers.n_down)
    up = -streak >= (1 if is_first else numbers.n_up)
    if not (down or up):
        return (min(max(level, low), high), last, streak, n_reversals, n_pinned), math.nan

    direction = DOWN if down else UP
    turned = last == -direction  # the first move, after STAY, is never a reversal
    n_reversals += 1 if turned else 0
    steps = numbers.steps_down if down else numbers.steps_up
    next_level = level + direction * steps[min(n_reversals, len(steps) - 1)]
    pinned = level <= low if down else level >= high
    n_pinned = (1 if turned else n_pinned + 1) if pinned else 0
    return (min(max(next_level, low), high), direction, 0, n_reversals, n_pinned), level if turned else math.nan


def _ending(numbers: StaircaseNumbers, order: Order, state: State, answers: Sequence[int]) -> int:
    _, direction, _, n_reversals, n_pinned = state
    if n_pinned >= numbers.n_at_bound:
        return CENSORED_ABOVE if direction == UP else CENSORED_BELOW
    if n_reversals >= numbers.n_reversals:
        return CONVERGED
    return TRIALS if len(answers) >= numbers.n_trials else GOES_ON


def _threshold(marks: Sequence[float]) -> float:
    """Return the mean of the last reversals, with equal peaks and valleys."""
    n, total = 0, 0.0
    for mark in marks:
        n += 0 if math.isnan(mark) else 1
    first, seen = DISCARDED + (n - DISCARDED) % 2, 0
    for mark in marks:
        if not math.isnan(mark):
            total += mark if seen >= first else 0.0
            seen += 1
    return total / (n - first) if n - first >= 2 else math.nan


class UpDown(SteppingRule["StaircaseRun"]):
    """Base of both staircases, which differ in the sizes of their steps."""

    start: float

    transition = Transition(_level, _ending, _start, _after, _threshold)
    _named = StaircaseNumbers

    @property
    @abstractmethod
    def point(self) -> str:
        """Target of the staircase, in words."""

    def begin(self, rng: np.random.Generator | None = None) -> "StaircaseRun":
        del rng
        return StaircaseRun(self)

    def _check(self, **schedules: tuple[float, ...]) -> None:
        """Refuse bounds, a start or steps that do not make a staircase."""
        owner, widest = type(self).__name__, self.high - self.low
        below(owner, low=self.low, high=self.high)
        among = f"a level between low ({self.low:g}) and high ({self.high:g})"
        expect(self.low <= self.start <= self.high, f"{owner}.start", f"{self.start:g}", among)

        for name, steps in schedules.items():
            numbers(f"{owner}.{name}", steps)
            some(f"{owner}.{name}", steps)
            for n, step in enumerate(steps):
                expected = f"above 0 and at most the range of levels ({widest:g})"
                expect(0 < step <= widest, f"{owner}.{name}[{n}]", f"{step:g}", expected)


@dataclass(frozen=True)
@constrained
class Staircase(UpDown):
    """Staircase that follows an n-up m-down rule.

    `n_down` correct responses in a row lower the level, `n_up` wrong responses in a row raise it. The target of 1 up, m
    down is the level of p = 0.5^(1/m) correct (Levitt, J. Acoust. Soc. Am. 49, 467, 1971, table I). Levels are in a
    unit in which equal steps make sense, such as decibels. Until the first reversal one response moves the level
    (`initial_rule`), as in PsychoPy. Step k is used after k reversals, and the last step from then on.

    There are three differences from PsychoPy's StairHandler. The next level starts from the level that was *delivered*.
    The staircase ends at `n_reversals` reversals or `n_trials` trials, whichever comes first (PsychoPy: when both are
    reached). After `n_at_bound` moves in a row to a level beyond `low` or `high` it ends as censored (PsychoPy
    continues).

    - `start`: Level of the first trial.
    - `steps`: Sizes of the steps. The first step is used until the first reversal, and so on. The last step is then
      kept.
    - `low`: Lowest level that is presented.
    - `high`: Highest level that is presented.
    - `n_up`: Number of wrong answers in a row that raise the level.
    - `n_down`: Number of right answers in a row that lower the level.
    - `n_reversals`: Number of reversals after which a track ends.
    - `n_trials`: Largest number of trials of a track.
    - `n_at_bound`: Number of moves in a row beyond a bound after which a track ends as censored.
    - `initial_rule`: True if a single answer moves the level until the first reversal.

    >>> rule = Staircase(start=20.0, steps=(4.0, 2.0), low=0.0, high=40.0, n_down=2, n_reversals=4, n_trials=50)
    >>> rule.after(1).level, rule.after(1).after(0).level
    (16.0, 18.0)
    """

    start: Finite
    steps: tuple[float, ...]
    low: Finite
    high: Finite
    n_up: Count = 1
    n_down: Count = 2
    n_reversals: Count = 8
    n_trials: Count = 60
    n_at_bound: Count = 3
    initial_rule: bool = True

    name = "staircase"

    def __post_init__(self) -> None:
        self._check(steps=self.steps)

    @property
    def steps_up(self) -> tuple[float, ...]:
        return self.steps

    @property
    def steps_down(self) -> tuple[float, ...]:
        return self.steps

    @property
    def point(self) -> str:
        return f"of {self.n_up} up, {self.n_down} down"


@dataclass(frozen=True)
@constrained
class WeightedStaircase(UpDown):
    """Staircase with steps up and down of different sizes.

    The target is p = (d_up / (d_up + d_down))^(1 / n_down). With `n_down` 1 it is the staircase of Kaernbach
    (Perception & Psychophysics 49, 227, 1991), above 1 the weighted transformed one of Garcia-Perez (Vision Research
    38, 1861, 1998). Reversals, bounds and endings are those of `Staircase`.

    - `steps_up`: Steps upwards, the first until the first reversal, and so on. The last step is then kept.
    - `steps_down`: Steps downwards, as many as `steps_up`.
    - `start`, `low`, `high`, `n_down`, `n_reversals`, `n_trials`, `n_at_bound`: As in `Staircase`.

    >>> rule = WeightedStaircase(start=20.0, steps_up=(6.0,), steps_down=(2.0,), low=0.0, high=40.0)
    >>> rule.target, rule.after(1).level, rule.after(0).level
    (0.75, 18.0, 26.0)
    """

    start: Finite
    steps_up: tuple[float, ...]
    steps_down: tuple[float, ...]
    low: Finite
    high: Finite
    n_down: Count = 1
    n_reversals: Count = 8
    n_trials: Count = 60
    n_at_bound: Count = 3

    name = "weighted_staircase"
    n_up = 1
    initial_rule = False

    def __post_init__(self) -> None:
        self._check(steps_up=self.steps_up, steps_down=self.steps_down)
        n_up, n_down = len(self.steps_up), len(self.steps_down)
        expect(n_up == n_down, "WeightedStaircase.steps_up", f"{n_up} steps and {n_down} steps_down", "pairs")

    @property
    def target(self) -> float:
        """Probability correct at which steps up and down balance."""
        up, down = self.steps_up[-1], self.steps_down[-1]
        return math.pow(up / (up + down), 1 / self.n_down)

    @property
    def point(self) -> str:
        return f"at a chance of {self.target:.2f}"


@dataclass(frozen=True)
class StaircaseRun(SteppingRun[UpDown]):
    """Run of a staircase."""

    @property
    def reversals(self) -> tuple[float, ...]:
        """Levels at which the staircase changed direction."""
        return tuple(mark for mark in self.marks if not math.isnan(mark))

    @property
    def streak(self) -> int:
        """Number of equal responses since the last move, negative if wrong."""
        return int(self.state[2])

    def _estimate(self) -> RuleThreshold:
        n_left = DISCARDED + (len(self.reversals) - DISCARDED) % 2  # as many peaks as valleys
        kept = self.reversals[n_left:]
        if len(kept) < 2:
            return RuleThreshold(note=f"too few reversals: {len(self.reversals)} {self.rule.point}")
        return RuleThreshold(self._threshold(), stdev(kept), len(kept), f"mean of reversals {self.rule.point}")
