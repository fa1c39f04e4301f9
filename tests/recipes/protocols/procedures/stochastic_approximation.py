"""Stochastic approximation: steps that become smaller with each trial."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tactometry.arguments.require import finite, within

from .procedure import RuleThreshold
from .stepping import GOES_ON, TRIALS, Numbers, Order, State, SteppingRule, SteppingRun, Transition


# numbers: start, step, low, high, target, n_trials; state: level asked
def _start(numbers: Numbers, order: Order) -> State:
    return (numbers[0],)


def _level(numbers: Numbers, order: Order, state: State) -> float:
    asked: float = state[0]
    return asked


def _after(
    numbers: Numbers, order: Order, state: State, answers: Sequence[int], levels: Sequence[float]
) -> tuple[State, float]:
    _, step, low, high, target, _ = numbers
    wanted = levels[-1] - step / len(answers) * (answers[-1] - target)
    asked = min(max(wanted, low), high)
    return (asked,), asked


def _ending(numbers: Numbers, order: Order, state: State, answers: Sequence[int]) -> int:
    return TRIALS if len(answers) >= numbers[5] else GOES_ON


def _threshold(marks: Sequence[float]) -> float:
    return marks[-1] if len(marks) else math.nan


@dataclass(frozen=True)
class StochasticApproximation(SteppingRule["StochasticApproximationRun"]):
    """The level falls by step / n times (response - target). Robbins and Monro, Ann. Math. Stat. 22, 400 (1951)."""

    start: float
    step: float
    low: float
    high: float
    target: float = 0.6
    n_trials: int = 30

    name: ClassVar[str] = "stochastic_approximation"
    transition = Transition(_level, _ending, _start, _after, _threshold)

    def __post_init__(self) -> None:
        finite("StochasticApproximation", start=self.start, step=self.step, low=self.low, high=self.high)
        within("StochasticApproximation", 0, 1, target=self.target)

    @property
    def numbers(self) -> Numbers:
        return self.start, self.step, self.low, self.high, self.target, self.n_trials

    def begin(self, rng: np.random.Generator | None = None) -> "StochasticApproximationRun":
        del rng
        return StochasticApproximationRun(self)


@dataclass(frozen=True)
class StochasticApproximationRun(SteppingRun[StochasticApproximation]):
    def _estimate(self) -> RuleThreshold:
        n, target = len(self.responses), self.rule.target
        return RuleThreshold(self._threshold(), n=n, note=f"last level at a chance of {target:g}")
