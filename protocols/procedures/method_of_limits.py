"""Method of limits."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Literal, NamedTuple, get_args

import numpy as np
from annotated_types import Ge, Interval
from numpy.typing import NDArray

from tactometry.arguments.constraints import Finite, constrained
from tactometry.arguments.require import expect, one_of

from .procedure import MOST_TRIALS, RuleThreshold
from .stepping import (
    ABORTED,
    CENSORED_ABOVE,
    CENSORED_BELOW,
    GOES_ON,
    TRIALS,
    Order,
    State,
    SteppingRule,
    SteppingRun,
    Transition,
)

Direction = Literal["ascending", "descending", "alternating"]
N_STEPS = 10_000
"""Largest number of steps in the range. Longer series are impractical."""
DIRECTIONS = get_args(Direction)
ASCENDING, ALTERNATING = 0, 2
UNCHANGED = math.inf
"""Mark of an answer that ends a series without a transition."""


class LimitsNumbers(NamedTuple):
    """Numbers of the rule. The direction is an index into `DIRECTIONS`."""

    low: float
    step: float
    n_steps: int
    n_series: int
    direction_index: int


# order: start of each series, in steps inwards
# state: finished series, answers in the current series, finished series without a transition
def _start(numbers: LimitsNumbers, order: Order) -> State:
    return 0, 0, 0


def _level(numbers: LimitsNumbers, order: Order, state: State) -> float:
    n_over: int = state[0]
    n_in_series: int = state[1]
    inwards = order[min(n_over, numbers.n_series - 1)] + n_in_series
    n = min(int(inwards), numbers.n_steps)  # a run that has ended still has a level
    ascending = n_over % 2 == 1 if numbers.direction_index == ALTERNATING else numbers.direction_index == ASCENDING
    return numbers.low + numbers.step * (n if ascending else numbers.n_steps - n)


def _after(
    numbers: LimitsNumbers, order: Order, state: State, answers: Sequence[int], levels: Sequence[float]
) -> tuple[State, float]:
    """Continue the series, or begin the next one at a transition."""
    n_over, n_in_series, n_unchanged = state
    ascending = n_over % 2 == 1 if numbers.direction_index == ALTERNATING else numbers.direction_index == ASCENDING
    turned = (answers[-1] == 1) == ascending  # in ascending series the answer changes to 1, in descending ones to 0
    if not turned and order[n_over] + n_in_series < numbers.n_steps:
        return (n_over, n_in_series + 1, n_unchanged), math.nan
    if turned and n_in_series > 0:
        return (n_over + 1, 0, n_unchanged), 0.5 * (levels[-2] + levels[-1])
    return (n_over + 1, 0, n_unchanged + 1), UNCHANGED


def _ending(numbers: LimitsNumbers, order: Order, state: State, answers: Sequence[int]) -> int:
    n_over, _, n_unchanged = state
    if n_over < numbers.n_series:
        return GOES_ON
    if 2 * n_unchanged <= n_over:
        return TRIALS
    more_yes = 2 * sum(answers) - len(answers)
    if more_yes == 0:
        return ABORTED
    return CENSORED_BELOW if more_yes > 0 else CENSORED_ABOVE


def _threshold(marks: Sequence[float]) -> float:
    """Return the mean of the transitions."""
    n, total = 0, 0.0
    for mark in marks:
        if math.isfinite(mark):
            n, total = n + 1, total + mark
    return total / n if n else math.nan


@dataclass(frozen=True)
@constrained
class MethodOfLimits(SteppingRule["MethodOfLimitsRun"]):
    """Ascending or descending series of levels, until the answer changes.

    An ascending series starts at `low` and ends at the first 1. A descending series starts at `high` and ends at the
    first 0. Alternating series begin with a descending one. The transition is half-way between the last two levels that
    were *delivered*, and the threshold is the mean of all transitions. Gescheider, Psychophysics: The Fundamentals, 3rd
    ed. (1997), chapter 3. A series has no transition if it reaches its last level without a change, or if its first
    answer ends it. If more than half of all series have none, the run is censored. It is aborted instead if as many
    answers are 1 as are 0, because such answers contradict each other.

    - `low`: Lowest level that is presented.
    - `high`: Highest level that is presented.
    - `step`: Distance between neighbouring levels.
    - `n_series`: Number of series in a track.
    - `n_start_steps`: With a generator, `begin` moves the start of each series inwards by 0 to this number of steps, so
      that participants cannot count steps.
    - `direction`: Direction of the series.

    >>> rule = MethodOfLimits(low=0.0, high=10.0, step=2.0, n_series=2)
    >>> for answer in (1, 1, 0, 0, 0, 1):
    ...     rule = rule.after(answer)
    >>> rule.transitions, rule.threshold
    ((7.0, 3.0), 5.0)
    """

    low: Finite
    high: Finite
    step: Finite
    n_series: Annotated[int, Interval(ge=0, le=MOST_TRIALS)] = 10
    direction: Direction = "alternating"
    n_start_steps: Annotated[int, Ge(0)] = 0

    name = "method_of_limits"
    _named = LimitsNumbers
    transition = Transition(_level, _ending, _start, _after, _threshold)
    unreplayed = "the series of the method of limits are not replayed"

    def __post_init__(self) -> None:
        one_of("MethodOfLimits.direction", self.direction, DIRECTIONS)
        are_steps = self.step > 0 and self.low < self.high <= self.low + N_STEPS * self.step
        range_ = f"{self.step:g} from low {self.low:g} to high {self.high:g}"
        few = f"above 0, low below high, and at most {N_STEPS} steps between them"
        expect(are_steps, "MethodOfLimits.step", range_, few)
        are_series = self.n_series >= 1 and self.n_steps > self.n_start_steps
        starts = f"with starts up to {self.n_start_steps} steps inwards"
        series = f"{self.n_series} series over {self.n_steps} steps {starts}"
        expect(are_series, "MethodOfLimits.n_series", series, "at least one series of at least two levels")

    @property
    def n_steps(self) -> int:
        # 0.3 / 0.1 is less than 3, so a quotient of whole steps may need rounding up
        return math.floor((self.high - self.low) / self.step * (1 + 1e-12))

    @property
    def direction_index(self) -> int:
        return DIRECTIONS.index(self.direction)

    @property
    def n_trials_at_most(self) -> int:
        return self.n_series * (self.n_steps + 1)

    def begin(self, rng: np.random.Generator | None = None) -> "MethodOfLimitsRun":
        """Return a run, with each series' start drawn by a generator."""
        if rng is None:
            return MethodOfLimitsRun(self, order=(0,) * self.n_series)
        drawn = rng.integers(self.n_start_steps + 1, size=self.n_series)
        return MethodOfLimitsRun(self, order=tuple(int(n) for n in drawn))

    def orders(self, n_sets: int, rng: np.random.Generator | None) -> NDArray[np.float64]:
        drawn = np.zeros((n_sets, self.n_series))
        return drawn if rng is None else rng.integers(self.n_start_steps + 1, size=drawn.shape).astype(np.float64)


@dataclass(frozen=True)
class MethodOfLimitsRun(SteppingRun[MethodOfLimits]):
    """Run of a `MethodOfLimits` with the starts of series in `order`."""

    @property
    def transitions(self) -> tuple[float | None, ...]:
        """Transitions of the finished series, None for a series without one."""
        return tuple(None if mark == UNCHANGED else mark for mark in self.marks if not math.isnan(mark))

    def _estimate(self) -> RuleThreshold:
        return RuleThreshold(self._threshold(), note=f"of {self.name}")
