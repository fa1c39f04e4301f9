"""Yes/no detection."""

from dataclasses import dataclass

import numpy as np

from tactometry.observers.decisions import Decision, detect
from tactometry.session.answer import Chosen
from tactometry.session.request import Choose
from tactometry.session.run import Course

from .task import Presentation, Reply, TaskKind, TrialOutcome, reply, touched


@dataclass(frozen=True)
class YesNo:
    """One stimulus or none, then: was it felt? Green and Swets, Signal Detection Theory and Psychophysics (1966)."""

    name = "yes_no"
    takes_catch_trials = True

    def trial(self, shown: Presentation, rng: np.random.Generator) -> Course[TrialOutcome]:
        del rng

        def heard(choice: Chosen) -> tuple[Reply, bool]:
            correct = choice.option == (shown.level is not None)
            return reply(choice, choice.option, correct=correct), correct

        return (yield from touched(shown, Choose("felt", (0, 1), ("no", "yes")), heard))


TASK = TaskKind(YesNo, questions={"felt": Decision(detect, 1)})
