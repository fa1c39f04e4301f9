"""Method of constant stimuli."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from tactometry.arguments.constraints import constrained
from tactometry.arguments.require import distinct, expect, numbers, some
from tactometry.errors import count_of

from .procedure import MOST_TRIALS, Count, FixedOrder, checked_outcome
from .stepping import (
    CENSORED_ABOVE,
    CENSORED_BELOW,
    GOES_ON,
    TRIALS,
    Numbers,
    Order,
    State,
    SteppingRule,
    SteppingRun,
    Transition,
)


# order: levels in their order; state: number of levels presented or skipped
def _level(numbers: Numbers, order: Order, state: State) -> float:
    n_done: int = state[0]
    return order[min(n_done, len(order) - 1)]  # a run that has ended still has a level


def _ending(numbers: Numbers, order: Order, state: State, answers: Sequence[int]) -> int:
    if state[0] < len(order):
        return GOES_ON
    n_yes = sum(answers)
    if n_yes == len(answers) > 0:
        return CENSORED_BELOW
    return CENSORED_ABOVE if n_yes == 0 < len(answers) else TRIALS


@dataclass(frozen=True)
@constrained
class ConstantStimuli(SteppingRule["ConstantStimuliRun"], FixedOrder):
    """Each level `repeats` times, whatever the responses.

    With a generator, `begin` shuffles in blocks: each level occurs once in each repeat, in random order. Without a
    generator the levels have their given order in every repeat. Gescheider, Psychophysics: The Fundamentals, 3rd ed.
    (1997), chapter 3. If all answers of a run are 1 or all are 0, the threshold is beyond the levels, and the run ends
    as censored.

    - `levels`: Levels, each presented once in a repeat.
    - `repeats`: Number of presentations of each level.

    >>> rule = ConstantStimuli(levels=(1.0, 2.0), repeats=1)
    >>> rule.level, rule.after(1).level, rule.after(1).after(0).finished
    (1.0, 2.0, True)
    """

    levels: tuple[float, ...]
    repeats: Count

    name = "constant_stimuli"
    transition = Transition(_level, _ending)
    unreplayed = "no estimate: the levels of constant stimuli do not depend on the answers"

    def __post_init__(self) -> None:
        numbers("ConstantStimuli.levels", self.levels)
        some("ConstantStimuli.levels", self.levels)
        once = "each level once; raise repeats to present it more often"
        distinct("ConstantStimuli.levels", self.levels, once)
        in_all = f"{self.repeats} of {count_of(len(self.levels), 'level')}"
        most = f"at most {MOST_TRIALS} trials in all"
        expect(self.n_trials_at_most <= MOST_TRIALS, "ConstantStimuli.repeats", in_all, most)

    @property
    def n_trials_at_most(self) -> int:
        return self.repeats * len(self.levels)

    def begin(self, rng: np.random.Generator | None = None) -> "ConstantStimuliRun":
        if rng is None:
            return ConstantStimuliRun(self, order=tuple(self.levels) * self.repeats)
        blocks = [rng.permutation(self.levels) for _ in range(self.repeats)]
        return ConstantStimuliRun(self, order=tuple(float(level) for block in blocks for level in block))

    def orders(self, n_sets: int, rng: np.random.Generator | None) -> NDArray[np.float64]:
        blocks = np.tile(np.asarray(self.levels, dtype=np.float64), (n_sets, self.repeats, 1))
        return (blocks if rng is None else rng.permuted(blocks, axis=2)).reshape(n_sets, -1)

    def skip(self) -> "ConstantStimuliRun":
        return self.view.skip()

    def take(self, response: int | bool) -> "ConstantStimuliRun":
        return self.view.take(response)


@dataclass(frozen=True)
class ConstantStimuliRun(SteppingRun[ConstantStimuli], FixedOrder):
    """Run of `ConstantStimuli` over the levels of `order`."""

    def take(self, response: int | bool) -> Self:
        return replace(self, responses=(*self.responses, checked_outcome(response, 2, "ConstantStimuli")))

    def skip(self) -> Self:
        return replace(self, state=(self.state[0] + 1,))
