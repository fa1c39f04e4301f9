"""The method of constant stimuli."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from tactometry.arguments.require import distinct, expect, numbers, some, whole
from tactometry.errors import count_of

from .procedure import MOST_TRIALS, Ending, FixedOrder, Rule, RuleThreshold, Run, checked_outcome


@dataclass(frozen=True)
class ConstantStimuli(Rule["ConstantStimuliRun"], FixedOrder):
    """Each of `levels` is presented `repeats` times, in an order that no response changes.

    `begin` with a generator shuffles in blocks: within each repeat every level comes once, in random order. Without one
    the levels come in their given order, repeat after repeat. Gescheider, Psychophysics: The Fundamentals, 3rd ed.
    (1997), chapter 3. A run whose answers are all 1 or all 0 tells only on which side of its levels the threshold lies,
    and ends as censored.

    Raises
    ------
    InvalidParameter
        If there is no level, a level is not finite or stands twice, `repeats` is below 1, or there are more than
        `MOST_TRIALS`.

    >>> rule = ConstantStimuli(levels=(1.0, 2.0), repeats=1)
    >>> rule.level, rule.after(1).level, rule.after(1).after(0).finished
    (1.0, 2.0, True)
    """

    levels: tuple[float, ...]
    repeats: int

    name = "constant_stimuli"
    unreplayed = "no rule: the levels of constant stimuli do not depend on the answers"

    def __post_init__(self) -> None:
        numbers("ConstantStimuli.levels", self.levels)
        whole("ConstantStimuli", lowest=1, repeats=self.repeats)
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

    def skip(self) -> "ConstantStimuliRun":
        return self.view.skip()

    def take(self, response: int | bool) -> "ConstantStimuliRun":
        return self.view.take(response)


@dataclass(frozen=True)
class ConstantStimuliRun(Run[ConstantStimuli], FixedOrder):
    """The levels in their `order`, of which the first `n_done` were presented or left out."""

    order: tuple[float, ...] = ()
    n_done: int = 0

    @property
    def level(self) -> float:
        return self.order[min(self.n_done, len(self.order) - 1)]  # a run that has ended still has a level

    @property
    def ending(self) -> Ending | None:
        if self.n_done < len(self.order):
            return None
        n_yes = sum(self.responses)
        if n_yes == len(self.responses) > 0:
            return "censored_below"
        return "censored_above" if n_yes == 0 < len(self.responses) else "trials"

    def take(self, response: int | bool) -> Self:
        return replace(self, responses=(*self.responses, checked_outcome(response, 2, "ConstantStimuli")))

    def skip(self) -> Self:
        return replace(self, n_done=self.n_done + 1)

    def _updated(self) -> Self:
        return self.skip()

    def _estimate(self) -> RuleThreshold:
        """None: the rule makes no estimate, a fit does (`tactometry.analysis.threshold.fitting.fit`)."""
        return RuleThreshold(note=self.rule.unreplayed)
