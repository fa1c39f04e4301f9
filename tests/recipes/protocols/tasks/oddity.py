"""Three-interval oddity task."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tactometry.observers.decisions import Decision, Felt, Observer
from tactometry.session.answer import Chosen
from tactometry.session.request import Choose

from .task import Presentation, Task, TaskKind, TrialCourse, TrialOutcome
from .touch import feel_in_turn, nth


@dataclass(frozen=True)
class Oddity(Task):
    """Oddity task: one random interval of three differs from the standard.

    That interval has the level of the track. The participant reports which interval differed.
    """

    standard_level: float

    name = "oddity"

    def trial(self, shown: Presentation, rng: np.random.Generator) -> TrialCourse:
        target = int(rng.integers(1, 4))
        levels = [shown.level if interval == target else self.standard_level for interval in (1, 2, 3)]
        touches = yield from feel_in_turn(shown.touch, [shown.stimulus] * 3, levels)
        outcome = TrialOutcome(touches, nth(touches, target), target=target, standard_level=self.standard_level)
        if not outcome.touches_valid:
            return outcome
        choice: Chosen = yield Choose("which_odd", (1, 2, 3), ("1", "2", "3"))
        return outcome.score(choice, correct=choice.option == target)


def farthest(observer: Observer, felt: Sequence[Felt], request: Choose, rng: np.random.Generator) -> int:
    """Return the interval that differs most from the median level of the three."""
    levels_db = np.array([each.level_db for each in felt])
    return request.options[observer.compare(list(np.abs(levels_db - np.median(levels_db))), rng)]


TASK = TaskKind(
    Oddity,
    example={"standard_level": 20.0},
    questions={"which_odd": Decision(farthest, 3)},
    own_levels=("standard_level",),
)
