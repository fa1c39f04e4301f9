"""Discrimination against a standard."""

from dataclasses import dataclass, replace

import numpy as np

from tactometry.observers.decisions import Decision, strongest
from tactometry.session.answer import Chosen
from tactometry.session.request import Choose

from .task import AgainstStandard, Presentation, Reply, TaskKind, TrialCourse


@dataclass(frozen=True)
class Comparison(AgainstStandard):
    """Comparison of a level with a standard ("which one is stronger?").

    Both are presented in random order, and the result is a just noticeable difference. The response, also for the
    procedure, is 1 if the participant called the level stronger. It is correct if the level was higher, and neither
    right nor wrong if both were equal. `target` is the interval of the level. Gescheider, Psychophysics: The
    Fundamentals, 3rd ed. (1997), chapter 3.
    """

    name = "comparison"

    def trial(self, shown: Presentation, rng: np.random.Generator) -> TrialCourse:
        outcome = yield from self.feel(shown, shown.level, rng)
        if not outcome.touches_valid:
            return outcome
        choice: Chosen = yield Choose("which_stronger", (1, 2), ("1", "2"))
        stronger = choice.option == outcome.target
        is_equal = shown.level is None or shown.level == self.standard_level
        is_higher = shown.level is not None and shown.level > self.standard_level
        answer = Reply(choice, int(stronger), None if is_equal else stronger == is_higher)
        return replace(outcome, replies=(answer,), success=stronger)


TASK = TaskKind(
    Comparison,
    example={"standard_level": 20.0},
    questions={"which_stronger": Decision(strongest)},
    own_levels=("standard_level",),
)
