"""m-interval forced choice."""

from dataclasses import dataclass

import numpy as np

from tactometry.errors import InvalidParameter
from tactometry.protocols.task import Outcome, Presentation
from tactometry.request import Choose, Chosen, Touched
from tactometry.run import Course


@dataclass(frozen=True)
class ForcedChoice:
    """`n_intervals` intervals of which one, drawn at random, holds the stimulus, then: which? Chance is 1/n_intervals.

    Green and Swets, Signal Detection Theory and Psychophysics (1966), section 2.4.

    Raises
    ------
    InvalidParameter
        If there are fewer than 2 or more than 4 intervals.
    """

    n_intervals: int = 2

    name = "forced_choice"
    takes_catch_trials = False

    def __post_init__(self) -> None:
        if not 2 <= self.n_intervals <= 4:
            raise InvalidParameter(f"ForcedChoice.n_intervals: found {self.n_intervals}, expected 2, 3 or 4")

    def trial(self, shown: Presentation, rng: np.random.Generator) -> Course[Outcome]:
        intervals = range(1, self.n_intervals + 1)
        target = int(rng.integers(1, self.n_intervals + 1))
        touches: list[Touched] = []
        for interval in intervals:
            level = shown.level if interval == target else None
            touches.append((yield shown.touch.request(shown.stimulus, level, interval)))
            if not touches[-1].valid:
                return Outcome(tuple(touches), touches[target - 1] if target <= interval else None, target=target)
        choice: Chosen = yield Choose("which_interval", tuple(intervals), tuple(str(n) for n in intervals))
        correct = choice.option == target if choice.valid else None
        return Outcome(tuple(touches), touches[target - 1], choice, correct, target)
