"""Magnitude estimation."""

from dataclasses import dataclass

import numpy as np

from tactometry.arguments.constraints import Positive, constrained
from tactometry.session.answer import Rated, Touched
from tactometry.session.request import Enter

from .task import Presentation, Reply, Task, TaskKind, TrialCourse, TrialOutcome


@dataclass(frozen=True)
@constrained
class Magnitude(Task):
    """A stimulus, then a number for its strength, from 0 up to `high`.

    Stevens, American Journal of Psychology 69, 1 (1956). The response for the procedure is whether anything was felt
    (above 0).

    - `high`: Highest number that can be entered. Without it there is no upper bound.
    """

    high: Positive | None = None

    name = "magnitude"
    takes_catch_trials = True

    def trial(self, shown: Presentation, rng: np.random.Generator) -> TrialCourse:
        del rng
        touch: Touched = yield shown.touch.request(shown.stimulus, shown.level, None)
        if not touch.valid:
            return TrialOutcome((touch,), touch)
        rated: Rated = yield Enter("how_strong", 0.0, self.high)
        is_felt = (rated.value or 0.0) > 0
        return TrialOutcome((touch,), touch, (Reply(rated, rated.value),), is_felt)


TASK = TaskKind(Magnitude)
