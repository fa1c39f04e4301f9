"""Stochastic approximation: steps that become smaller with each trial."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from tactometry.arguments.require import finite, within

from .procedure import Ending, Rule, RuleThreshold, Run


@dataclass(frozen=True)
class StochasticApproximation(Rule["StochasticApproximationRun"]):
    """The level falls by step / n times (response - target). Robbins and Monro, Ann. Math. Stat. 22, 400 (1951)."""

    start: float
    step: float
    low: float
    high: float
    target: float = 0.6
    n_trials: int = 30

    name: ClassVar[str] = "stochastic_approximation"

    def __post_init__(self) -> None:
        finite("StochasticApproximation", start=self.start, step=self.step, low=self.low, high=self.high)
        within("StochasticApproximation", 0, 1, target=self.target)

    def begin(self, rng: np.random.Generator | None = None) -> "StochasticApproximationRun":
        del rng
        return StochasticApproximationRun(self, asked=self.start)


@dataclass(frozen=True)
class StochasticApproximationRun(Run[StochasticApproximation]):
    asked: float = 0.0

    @property
    def level(self) -> float:
        return self.asked

    @property
    def ending(self) -> Ending | None:
        return "trials" if len(self.responses) >= self.rule.n_trials else None

    def _updated(self) -> "StochasticApproximationRun":
        n, away = len(self.responses), self.responses[-1] - self.rule.target
        wanted = self.delivered[-1] - self.rule.step / n * away
        return replace(self, asked=min(max(wanted, self.rule.low), self.rule.high))

    def _estimate(self) -> RuleThreshold:
        return RuleThreshold(self.asked, n=len(self.responses), note=f"last level at a chance of {self.rule.target:g}")
