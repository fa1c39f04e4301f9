"""Yes/no detection."""

from dataclasses import dataclass

import numpy as np

from tactometry.protocols.task import Outcome, Presentation, reply
from tactometry.request import Choose, Chosen, Touched
from tactometry.run import Course


@dataclass(frozen=True)
class YesNo:
    """One stimulus or none, then: was it felt? Green and Swets, Signal Detection Theory and Psychophysics (1966)."""

    name = "yes_no"
    takes_catch_trials = True

    def trial(self, shown: Presentation, rng: np.random.Generator) -> Course[Outcome]:
        del rng
        touch: Touched = yield shown.touch.request(shown.stimulus, shown.level, None)
        if not touch.valid:
            return Outcome((touch,), touch)
        choice: Chosen = yield Choose("felt", (0, 1), ("no", "yes"))
        correct = choice.option == (shown.level is not None)
        return Outcome((touch,), touch, (reply(choice, choice.option, correct=correct),), success=correct)
