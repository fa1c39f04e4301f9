"""Rules whose steps are a `Transition` of plain numbers: all but those that weigh a grid of functions."""

from abc import abstractmethod
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import isnan
from typing import Any, ClassVar, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from .procedure import Ending, Rule, RuleThreshold, Run
from .transition import Numbers, State, Transition, ending_of

RunT = TypeVar("RunT", bound="SteppingRun[Any]")


class SteppingRule(Rule[RunT]):
    """Numbers of a rule that has a `transition`."""

    transition: ClassVar[Transition]

    @property
    @abstractmethod
    def numbers(self) -> Numbers:
        """As the functions of the transition take them."""

    def orders(self, n_sets: int, rng: np.random.Generator | None) -> NDArray[np.float64]:
        """What is drawn before the first answers of so many runs, (n_sets, n_drawn); most rules draw nothing."""
        del rng
        return np.zeros((n_sets, 0))


RuleT = TypeVar("RuleT", bound=SteppingRule[Any])


@dataclass(frozen=True)
class SteppingRun(Run[RuleT]):
    """How far such a rule has come.

    - `order`: What was drawn before the first answer.
    - `state`: What the transition makes of the answers; before the first one where none is given.
    - `marks`: One for each answer: a level that the estimate rests on, else NaN.
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
        """The rule's own, None where it has none yet."""
        level = self.rule.transition.threshold(self.marks)
        return None if isnan(level) else level

    def _estimate(self) -> RuleThreshold:
        return RuleThreshold(self._threshold(), note=self.rule.unreplayed)

    def _updated(self) -> Self:
        step = self.rule.transition.after
        state, mark = step(self.rule.numbers, self.order, self.state, self.responses, self.delivered)
        return replace(self, state=state, marks=(*self.marks, mark))
