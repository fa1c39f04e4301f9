"""Practice until a criterion is met."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from tactometry.arguments.require import expect, numbers, one_of, some, whole
from tactometry.trials.tasks import PRACTICE_CRITERION

from .procedure import RuleThreshold
from .stepping import SteppingRule, SteppingRun
from .transition import CONVERGED, GOES_ON, TRIALS, Numbers, Order, State, Transition


# numbers: levels, n_correct, n_of, n_trials; state: the number of answers
def _start(numbers: Numbers, order: Order) -> State:
    return (0,)


def _level(numbers: Numbers, order: Order, state: State) -> float:
    levels = numbers[0]
    level: float = levels[state[0] % len(levels)]
    return level


def _after(
    numbers: Numbers, order: Order, state: State, answers: Sequence[int], levels: Sequence[float]
) -> tuple[State, float]:
    return (state[0] + 1,), math.nan


def _ending(numbers: Numbers, order: Order, state: State, answers: Sequence[int]) -> int:
    _, n_correct, n_of, n_trials = numbers
    if sum(answers[-n_of:]) >= n_correct:
        return CONVERGED
    return TRIALS if len(answers) >= n_trials else GOES_ON


def _threshold(marks: Sequence[float]) -> float:
    """None: practice measures nothing."""
    return math.nan


OnMiss = Literal["go_on", "ask"]


@dataclass(frozen=True)
class Practice(SteppingRule["PracticeRun"]):
    """Easy levels in turn until `n_correct` of the last `n_of` answers were right, `n_trials` at most.

    It ends as ``converged`` when the criterion was met, else as ``trials``.

    - `levels`: Easy ones, in turn.
    - `n_correct`: Number of correct answers among the last `n_of` that ends the practice.
    - `n_of`: Number of last answers among which `n_correct` must be correct.
    - `n_trials`: Largest number of trials; the practice then ends without its criterion.
    - `on_miss`: With ``ask``, the experimenter chooses after a practice that missed its criterion: practice again, go
      on, or end the session. With ``go_on`` the session goes on.

    Raises `InvalidParameter` if there is no level, or the counts make no criterion.

    >>> rule = Practice(levels=(40.0, 30.0), n_correct=2, n_of=3, n_trials=10)
    >>> rule.after(1).level, rule.after(1).after(0).after(1).ending
    (30.0, 'converged')
    """

    levels: tuple[float, ...]
    n_correct: int = PRACTICE_CRITERION[0]
    n_of: int = PRACTICE_CRITERION[1]
    n_trials: int = 20
    on_miss: OnMiss = "go_on"

    name = "practice"
    transition = Transition(_start, _level, _after, _ending, _threshold)

    def __post_init__(self) -> None:
        numbers("Practice.levels", self.levels)
        whole("Practice", lowest=1, n_correct=self.n_correct, n_of=self.n_of, n_trials=self.n_trials)
        some("Practice.levels", self.levels)
        one_of("Practice.on_miss", self.on_miss, get_args(OnMiss))
        for name, most in (("n_correct", "n_of"), ("n_of", "n_trials")):
            number, highest = getattr(self, name), getattr(self, most)
            possible = f"from 1 to {highest}, {most}; it must be possible to meet the criterion"
            expect(number <= highest, f"Practice.{name}", number, possible)

    @property
    def numbers(self) -> Numbers:
        return self.levels, self.n_correct, self.n_of, self.n_trials

    def begin(self, rng: np.random.Generator | None = None) -> "PracticeRun":
        del rng
        return PracticeRun(self)


@dataclass(frozen=True)
class PracticeRun(SteppingRun[Practice]):
    """Its answers are all that it knows."""

    def _estimate(self) -> RuleThreshold:
        return RuleThreshold(note="practice measures nothing")
