"""Practice until a criterion is met."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from tactometry.arguments.require import expect, numbers, some, whole

from .procedure import Ending, Rule, RuleThreshold, Run


@dataclass(frozen=True)
class Practice(Rule["PracticeRun"]):
    """Easy levels in turn until `n_correct` of the last `n_of` answers were right, `n_trials` at most.

    It ends as ``converged`` when the criterion was met, else as ``trials``.

    Raises
    ------
    InvalidParameter
        If there is no level, or the counts make no criterion.

    >>> rule = Practice(levels=(40.0, 30.0), n_correct=2, n_of=3, n_trials=10)
    >>> rule.after(1).level, rule.after(1).after(0).after(1).ending
    (30.0, 'converged')
    """

    levels: tuple[float, ...]
    n_correct: int = 4
    n_of: int = 5
    n_trials: int = 20

    name = "practice"

    def __post_init__(self) -> None:
        numbers("Practice.levels", self.levels)
        whole("Practice", lowest=1, n_correct=self.n_correct, n_of=self.n_of, n_trials=self.n_trials)
        some("Practice.levels", self.levels)
        for name, most in (("n_correct", "n_of"), ("n_of", "n_trials")):
            number, highest = getattr(self, name), getattr(self, most)
            possible = f"from 1 to {highest}, {most}; it must be possible to meet the criterion"
            expect(number <= highest, f"Practice.{name}", number, possible)

    def begin(self, rng: np.random.Generator | None = None) -> "PracticeRun":
        del rng
        return PracticeRun(self)


@dataclass(frozen=True)
class PracticeRun(Run[Practice]):
    """Its answers are all that it knows."""

    @property
    def level(self) -> float:
        return self.rule.levels[len(self.responses) % len(self.rule.levels)]

    @property
    def ending(self) -> Ending | None:
        if sum(self.responses[-self.rule.n_of :]) >= self.rule.n_correct:
            return "converged"
        return "trials" if len(self.responses) >= self.rule.n_trials else None

    def _updated(self) -> Self:
        return self

    def _estimate(self) -> RuleThreshold:
        return RuleThreshold(note="practice measures nothing")
