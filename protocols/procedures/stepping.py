"""Rules whose steps are pure functions of numbers (`Transition`).

A session calls these functions, and a batch compiles them.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, ClassVar, Self, TypeVar, get_args

import numpy as np
from numpy.typing import NDArray

from .procedure import Ending, Rule, RuleThreshold, Run

Numbers = tuple[Any, ...]
Order = Sequence[float]
State = tuple[Any, ...]
GOES_ON, CONVERGED, TRIALS, CENSORED_ABOVE, CENSORED_BELOW, ABORTED = range(6)
"""Codes of `Transition.ending`. Runs with one of the last three endings have no threshold."""


def _no_answer(numbers: Numbers, order: Order) -> State:
    return (0,)


def _one_more(
    numbers: Numbers, order: Order, state: State, answers: Sequence[int], levels: Sequence[float]
) -> tuple[State, float]:
    return (state[0] + 1,), math.nan


def _no_threshold(marks: Sequence[float]) -> float:
    return math.nan


@dataclass(frozen=True)
class Transition:
    """Steps of a type of procedure, as functions that numba can compile.

    `numbers` is a named tuple with the numbers and sequences of numbers of the rule. `order` contains the numbers drawn
    before the first answer, none for most rules. `state` is a tuple of numbers, each of which is always an integer or
    always a float. `answers` and `levels` are the history including the last answer.

    - `level`: ``level(numbers, order, state)``: the next level, even if the run has ended.
    - `ending`: ``ending(numbers, order, state, answers)``: `GOES_ON`, or the code of the ending.
    - `start`: ``start(numbers, order)``: the state before the first answer. By default it is the number of answers, 0.
    - `after`: ``after(numbers, order, state, answers, levels)``: the state after the last answer, and its mark. The
      mark is a level used for the estimate (a reversal, a transition), else NaN. By default these are the number of
      answers and NaN.
    - `threshold`: ``threshold(marks)``: the estimate of the rule from the marks of all answers. By default it is NaN.
    """

    level: Callable[..., float]
    ending: Callable[..., int]
    start: Callable[..., State] = _no_answer
    after: Callable[..., tuple[State, float]] = _one_more
    threshold: Callable[[Sequence[float]], float] = _no_threshold


def ending_of(code: int) -> Ending | None:
    """Return the ending of a code.

    >>> ending_of(GOES_ON), ending_of(CENSORED_BELOW)
    (None, 'censored_below')
    """
    endings: tuple[Ending, ...] = get_args(Ending)
    return endings[code - 1] if code else None


RunT = TypeVar("RunT", bound="SteppingRun[Any]")


class SteppingRule(Rule[RunT]):
    """Settings of a rule with a `transition`, as the tuple `_named`."""

    transition: ClassVar[Transition]
    _named: ClassVar[type[Numbers]] = tuple

    @property
    def numbers(self) -> Numbers:
        return self._named(*(getattr(self, name) for name in getattr(self._named, "_fields", ())))

    def begin(self, rng: np.random.Generator | None = None) -> RunT:
        del rng
        run: Any = SteppingRun(self)
        return run  # type: ignore[no-any-return]

    def orders(self, n_sets: int, rng: np.random.Generator | None) -> NDArray[np.float64]:
        """Draw the orders of runs, (n_sets, n_drawn), empty for most rules."""
        del rng
        return np.zeros((n_sets, 0))


RuleT = TypeVar("RuleT", bound=SteppingRule[Any])


@dataclass(frozen=True)
class SteppingRun(Run[RuleT]):
    """Run of a rule with a transition.

    - `order`: Numbers drawn before the first answer.
    - `state`: State of the transition. The default is the state before the first answer.
    - `marks`: For each answer, a level used for the estimate, else NaN.
    """

    order: tuple[float, ...] = ()
    state: State = field(default=(), repr=False)
    marks: tuple[float, ...] = field(default=(), repr=False)

    def __post_init__(self) -> None:
        if not self.state:
            object.__setattr__(self, "state", self.rule.transition.start(self.rule.numbers, self.order))

    @property
    def level(self) -> float:
        return self.rule.transition.level(self.rule.numbers, self.order, self.state)

    @cached_property
    def ending(self) -> Ending | None:
        return ending_of(self.rule.transition.ending(self.rule.numbers, self.order, self.state, self.responses))

    def _threshold(self) -> float | None:
        level = self.rule.transition.threshold(self.marks)
        return None if math.isnan(level) else level

    def _estimate(self) -> RuleThreshold:
        return RuleThreshold(self._threshold(), note=self.rule.unreplayed)

    def _updated(self) -> Self:
        step = self.rule.transition.after
        state, mark = step(self.rule.numbers, self.order, self.state, self.responses, self.delivered)
        return replace(self, state=state, marks=(*self.marks, mark))
