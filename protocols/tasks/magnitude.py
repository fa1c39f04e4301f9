"""Magnitude estimation."""

from dataclasses import dataclass

import numpy as np

from tactometry.arguments.require import positive
from tactometry.session.answer import Rated
from tactometry.session.request import Enter
from tactometry.session.run import Course

from .task import Presentation, Reply, TaskKind, TrialOutcome, reply, touched


@dataclass(frozen=True)
class Magnitude:
    """One stimulus, then a number for its strength, from 0, without a modulus unless `high` bounds it.

    Stevens, American Journal of Psychology 69, 1 (1956). The procedure is told whether anything was felt (above 0).

    Raises
    ------
    InvalidParameter
        If `high` is given and not a finite number above 0.
    """

    high: float | None = None

    name = "magnitude"
    takes_catch_trials = True

    def __post_init__(self) -> None:
        if self.high is not None:
            positive("Magnitude", high=self.high)

    def trial(self, shown: Presentation, rng: np.random.Generator) -> Course[TrialOutcome]:
        del rng

        def heard(rated: Rated) -> tuple[Reply, bool]:
            return reply(rated, rated.value), (rated.value or 0.0) > 0

        return (yield from touched(shown, Enter("how_strong", 0.0, self.high), heard))


TASK = TaskKind(Magnitude)
