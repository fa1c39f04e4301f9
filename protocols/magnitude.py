"""Magnitude estimation."""

from dataclasses import dataclass

import numpy as np

from tactometry.protocols.task import Outcome, Presentation, reply
from tactometry.request import Enter, Rated, Touched
from tactometry.run import Course


@dataclass(frozen=True)
class Magnitude:
    """One stimulus, then a number for its strength, from 0, without a modulus unless `high` bounds it.

    Stevens, American Journal of Psychology 69, 1 (1956). The procedure is told whether anything was felt (above 0).
    """

    high: float | None = None

    name = "magnitude"
    takes_catch_trials = True

    def trial(self, shown: Presentation, rng: np.random.Generator) -> Course[Outcome]:
        del rng
        touch: Touched = yield shown.touch.request(shown.stimulus, shown.level, None)
        if not touch.valid:
            return Outcome((touch,), touch)
        rated: Rated = yield Enter("how_strong", 0.0, self.high)
        return Outcome((touch,), touch, (reply(rated, rated.value),), success=(rated.value or 0.0) > 0)
