"""Yes/no detection."""

from dataclasses import dataclass

import numpy as np

from tactometry.observers.decisions import Decision, detect
from tactometry.session.answer import Chosen, Touched
from tactometry.session.request import Choose

from .task import Presentation, Task, TaskKind, TrialCourse, TrialOutcome


@dataclass(frozen=True)
class YesNo(Task):
    """One stimulus or none ("did you feel it?"). Green and Swets, Signal Detection Theory and Psychophysics (1966)."""

    name = "yes_no"
    takes_catch_trials = True

    def trial(self, shown: Presentation, rng: np.random.Generator) -> TrialCourse:
        del rng
        touch: Touched = yield shown.touch.request(shown.stimulus, shown.level, None)
        outcome = TrialOutcome((touch,), touch)
        if not touch.valid:
            return outcome
        choice: Chosen = yield Choose("felt", (0, 1), ("no", "yes"))
        return outcome.score(choice, correct=choice.option == (shown.level is not None))


TASK = TaskKind(YesNo, questions={"felt": Decision(detect, 1)})
