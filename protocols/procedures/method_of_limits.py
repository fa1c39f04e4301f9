"""The method of limits."""

import math
from dataclasses import dataclass, replace
from statistics import fmean
from typing import Literal, Self, get_args

import numpy as np

from tactometry.arguments.require import expect, finite, one_of, whole

from .procedure import MOST_TRIALS, Ending, Rule, RuleThreshold, Run

Direction = Literal["ascending", "descending", "alternating"]
N_STEPS = 10_000
"""More make no series that anybody sits through."""


@dataclass(frozen=True)
class MethodOfLimits(Rule["MethodOfLimitsRun"]):
    """Series of rising or falling levels, each until the answer changes.

    An ascending series starts at `low` and ends at the first 1, a descending one starts at `high` and ends at the
    first 0; alternating series begin with a descending one. The transition lies half-way between the last two levels
    that were *delivered*; the threshold is the mean of all transitions. Gescheider, Psychophysics: The Fundamentals,
    3rd ed. (1997), chapter 3. A series that comes to its last level, or begins, without a change has no transition;
    when more than half of all series have none, the run is censored, or aborted if it has as many 1 as 0: such answers
    contradict each other and bound nothing.

    Parameters
    ----------
    low, high, step : float
        Levels lie whole steps from `low` up to `high`.
    n_series : int
        How many series there are.
    n_start_steps : int
        `begin` with a generator moves the start of each series inwards by 0 to this many steps, against the habit of
        counting.

    Raises
    ------
    InvalidParameter
        If bounds, step or counts make no series of at least two levels.

    >>> rule = MethodOfLimits(low=0.0, high=10.0, step=2.0, n_series=2)
    >>> for answer in (1, 1, 0, 0, 0, 1):
    ...     rule = rule.after(answer)
    >>> rule.transitions, rule.threshold
    ((7.0, 3.0), 5.0)
    """

    low: float
    high: float
    step: float
    n_series: int = 10
    direction: Direction = "alternating"
    n_start_steps: int = 0

    name = "method_of_limits"
    unreplayed = "the series of the method of limits are not replayed"

    def __post_init__(self) -> None:
        one_of("MethodOfLimits.direction", self.direction, get_args(Direction))
        finite("MethodOfLimits", low=self.low, high=self.high, step=self.step)
        whole("MethodOfLimits", lowest=0, highest=MOST_TRIALS, n_series=self.n_series)
        whole("MethodOfLimits", lowest=0, n_start_steps=self.n_start_steps)
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
        # Whole steps may divide to just less than a whole number: 0.3 / 0.1 does.
        return math.floor((self.high - self.low) / self.step * (1 + 1e-12))

    @property
    def n_trials_at_most(self) -> int:
        return self.n_series * (self.n_steps + 1)

    def begin(self, rng: np.random.Generator | None = None) -> "MethodOfLimitsRun":
        """With a generator each series starts at another level, drawn from `n_start_steps` + 1 of them."""
        if rng is None:
            return MethodOfLimitsRun(self, starts=(0,) * self.n_series)
        drawn = rng.integers(self.n_start_steps + 1, size=self.n_series)
        return MethodOfLimitsRun(self, starts=tuple(int(n) for n in drawn))


@dataclass(frozen=True)
class MethodOfLimitsRun(Run[MethodOfLimits]):
    """The series so far: where each begins in steps inwards (`starts`), the `transitions` of those that are over, and
    how many levels of the present one were answered."""

    starts: tuple[int, ...] = ()
    transitions: tuple[float | None, ...] = ()
    n_in_series: int = 0

    @property
    def ascending(self) -> bool:
        """Whether the present series rises."""
        if self.rule.direction == "alternating":
            return len(self.transitions) % 2 == 1
        return self.rule.direction == "ascending"

    @property
    def level(self) -> float:
        rule = self.rule
        series = min(len(self.transitions), rule.n_series - 1)  # a run that has ended still has a level
        steps = min(self.starts[series] + self.n_in_series, rule.n_steps)
        return rule.low + rule.step * (steps if self.ascending else rule.n_steps - steps)

    @property
    def ending(self) -> Ending | None:
        if len(self.transitions) < self.rule.n_series:
            return None
        if 2 * self.transitions.count(None) <= self.rule.n_series:
            return "trials"
        more_yes = 2 * sum(self.responses) - len(self.responses)
        if more_yes == 0:
            return "aborted"
        return "censored_below" if more_yes > 0 else "censored_above"

    def _estimate(self) -> RuleThreshold:
        """The mean of the transitions; None where there is none."""
        known = [transition for transition in self.transitions if transition is not None]
        return RuleThreshold(fmean(known) if known else None, note=f"of {self.name}")

    def _updated(self) -> Self:
        """The next level of the series, or the first of the next one."""
        # Rising levels change the answer to 1, falling ones to 0.
        if self.responses[-1] == self.ascending or self._at_last():
            return replace(self, transitions=(*self.transitions, self._transition()), n_in_series=0)
        return replace(self, n_in_series=self.n_in_series + 1)

    def _at_last(self) -> bool:
        return self.starts[len(self.transitions)] + self.n_in_series >= self.rule.n_steps

    def _transition(self) -> float | None:
        """Half-way between the last two levels of the series, if the last answer is another than the one before it."""
        changed = self.n_in_series > 0 and self.responses[-1] == self.ascending
        return 0.5 * (self.delivered[-2] + self.delivered[-1]) if changed else None
