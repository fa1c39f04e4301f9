"""Discrimination against a standard."""

from dataclasses import dataclass, replace

import numpy as np

from tactometry.arguments.require import finite
from tactometry.observers.decisions import Decision, strongest
from tactometry.session.answer import Chosen
from tactometry.session.request import Choose

from .task import Presentation, Reply, Task, TaskKind, TrialCourse, TrialOutcome
from .touch import feel_in_turn, nth


@dataclass(frozen=True)
class Comparison(Task):
    """The standard and a level in random order, then: which is stronger? For just noticeable differences.

    The response is 1 if the level was called stronger than the standard, and it is what the procedure is told; it is
    correct if the level was higher, and not defined at equality. `target` is the interval of the level. Gescheider,
    Psychophysics: The Fundamentals, 3rd ed. (1997), chapter 3.

    Raises
    ------
    InvalidParameter
        If the standard is not a finite number.
    """

    standard_level: float

    name = "comparison"

    def __post_init__(self) -> None:
        finite("Comparison", standard_level=self.standard_level)

    def trial(self, shown: Presentation, rng: np.random.Generator) -> TrialCourse:
        target = int(rng.integers(1, 3))
        levels = [shown.level if interval == target else self.standard_level for interval in (1, 2)]
        touches = yield from feel_in_turn(shown.touch, [shown.stimulus] * 2, levels)
        outcome = TrialOutcome(touches, nth(touches, target), target=target, standard_level=self.standard_level)
        if not outcome.touches_valid:
            return outcome
        choice: Chosen = yield Choose("which_stronger", (1, 2), ("1", "2"))
        stronger = choice.option == target
        answer = Reply(choice, int(stronger), self._correct(shown.level, stronger=stronger))
        return replace(outcome, replies=(answer,), success=stronger)

    def _correct(self, level: float | None, *, stronger: bool) -> bool | None:
        return None if level is None or level == self.standard_level else stronger == (level > self.standard_level)


TASK = TaskKind(
    Comparison,
    example={"standard_level": 20.0},
    questions={"which_stronger": Decision(strongest)},
    own_levels=("standard_level",),
)
