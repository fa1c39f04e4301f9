"""Method of adjustment."""

from dataclasses import dataclass

import numpy as np

from tactometry.arguments.constraints import Finite, constrained
from tactometry.arguments.require import below, expect
from tactometry.session.answer import Adjusted
from tactometry.session.request import Adjust, Play, Slide

from .task import Presentation, Reply, Task, TaskKind, TrialCourse, TrialOutcome


@dataclass(frozen=True)
@constrained
class AdjustmentTask(Task):
    """The participant sets the level, starting at the procedure's level.

    The level changes in steps of `step` within the bounds. In the row, `level` is the start and the response is the
    final level. Gescheider, Psychophysics: The Fundamentals, 3rd ed. (1997), chapter 3.

    - `step`: Change of the level per press of an arrow key.
    - `low`: Lowest level that can be set.
    - `high`: Highest level that can be set.
    """

    step: Finite
    low: Finite
    high: Finite

    name = "adjustment"

    def __post_init__(self) -> None:
        below("AdjustmentTask", low=self.low, high=self.high)
        widest = self.high - self.low
        expected = f"above 0 and at most the range ({widest:g})"
        expect(0 < self.step <= widest, "AdjustmentTask.step", f"{self.step:g}", expected)

    def check_starts(self, low: float, high: float) -> None:
        """Refuse a procedure with start levels outside the bounds."""
        starts = f"start levels of an adjustment from {low:g} to {high:g}"
        bounds = f"start levels within the bounds of the task ({self.low:g} to {self.high:g})"
        expect(self.low <= low <= high <= self.high, "procedure", starts, bounds)

    def trial(self, shown: Presentation, rng: np.random.Generator) -> TrialCourse:
        del rng
        assert shown.level is not None
        touch = shown.touch.request(shown.stimulus, shown.level, None)
        speed_m_per_s = touch.speed_m_per_s if isinstance(touch, Slide) else None
        force_n = None if isinstance(touch, Play) else touch.target_n
        adjusted: Adjusted = yield Adjust(
            shown.stimulus, shown.level, self.step, self.low, self.high, force_n, speed_m_per_s
        )
        return TrialOutcome((), None, (Reply(adjusted, adjusted.level),))


TASK = TaskKind(
    AdjustmentTask,
    example={"step": 1.0, "low": 0.0, "high": 40.0},
    own_levels=("high",),
    check_levels=AdjustmentTask.check_starts,
)
