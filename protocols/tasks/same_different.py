"""Same-different discrimination."""

from dataclasses import dataclass

import numpy as np

from tactometry.observers.decisions import Decision, differ
from tactometry.session.answer import Chosen
from tactometry.session.request import Choose

from .task import AgainstStandard, Presentation, TaskKind, TrialCourse


@dataclass(frozen=True)
class SameDifferent(AgainstStandard):
    """The standard and a level in random order ("same or different?").

    Catch trials present the standard twice. The response is 1 for "different". Macmillan and Creelman, Detection
    Theory, 2nd ed. (2005), chapter 9.
    """

    name = "same_different"
    takes_catch_trials = True

    def trial(self, shown: Presentation, rng: np.random.Generator) -> TrialCourse:
        outcome = yield from self.feel(shown, self.standard_level if shown.level is None else shown.level, rng)
        if not outcome.touches_valid:
            return outcome
        choice: Chosen = yield Choose("same_different", (0, 1), ("same", "different"))
        return outcome.score(choice, correct=choice.option == (shown.level is not None))


TASK = TaskKind(
    SameDifferent,
    example={"standard_level": 20.0},
    questions={"same_different": Decision(differ, 2)},
    own_levels=("standard_level",),
)
