"""Same or different?"""

from dataclasses import dataclass

import numpy as np

from tactometry.arguments.require import finite
from tactometry.observers.decisions import Decision, differ
from tactometry.session.answer import Chosen
from tactometry.session.request import Choose

from .task import Presentation, Task, TaskKind, TrialCourse, TrialOutcome
from .touch import feel_in_turn, nth


@dataclass(frozen=True)
class SameDifferent(Task):
    """The standard and a level in random order, or (as catch trials) the standard twice, then: same or different?

    The response is 1 for "different". Macmillan and Creelman, Detection Theory, 2nd ed. (2005), chapter 9.

    Raises
    ------
    InvalidParameter
        If the standard is not a finite number.
    """

    standard_level: float

    name = "same_different"
    takes_catch_trials = True

    def __post_init__(self) -> None:
        finite("SameDifferent", standard_level=self.standard_level)

    def trial(self, shown: Presentation, rng: np.random.Generator) -> TrialCourse:
        target = int(rng.integers(1, 3))
        compared = self.standard_level if shown.level is None else shown.level
        levels = [compared if interval == target else self.standard_level for interval in (1, 2)]
        touches = yield from feel_in_turn(shown.touch, [shown.stimulus] * 2, levels)
        outcome = TrialOutcome(touches, nth(touches, target), target=target, standard_level=self.standard_level)
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
