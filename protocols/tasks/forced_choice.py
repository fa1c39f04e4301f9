"""Forced choice among m intervals."""

from dataclasses import dataclass

import numpy as np

from tactometry.arguments.constraints import excerpt
from tactometry.arguments.require import expect
from tactometry.observers.decisions import Decision, strongest
from tactometry.session.answer import Chosen
from tactometry.session.request import Choose

from .task import Presentation, Task, TaskKind, TrialCourse, TrialOutcome
from .touch import feel_in_turn, nth


@dataclass(frozen=True)
class ForcedChoice(Task):
    """Forced choice among intervals ("which one contains the stimulus?").

    Green and Swets, Signal Detection Theory and Psychophysics (1966), section 2.4.

    - `n_intervals`: Number of intervals of a trial. The chance level is 1 divided by it.
    """

    n_intervals: int = 2

    name = "forced_choice"

    def __post_init__(self) -> None:
        expect(self.n_intervals in (2, 3, 4), "ForcedChoice.n_intervals", excerpt(self.n_intervals), "2, 3 or 4")

    def trial(self, shown: Presentation, rng: np.random.Generator) -> TrialCourse:
        intervals = tuple(range(1, self.n_intervals + 1))
        target = int(rng.integers(1, self.n_intervals + 1))
        levels = [shown.level if interval == target else None for interval in intervals]
        touches = yield from feel_in_turn(shown.touch, [shown.stimulus] * self.n_intervals, levels)
        outcome = TrialOutcome(touches, nth(touches, target), target=target)
        if not outcome.touches_valid:
            return outcome
        choice: Chosen = yield Choose("which_interval", intervals, tuple(map(str, intervals)))
        return outcome.score(choice, correct=choice.option == target)


TASK = TaskKind(ForcedChoice, questions={"which_interval": Decision(strongest)})
