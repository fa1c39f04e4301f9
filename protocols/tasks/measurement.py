"""Measurement of a stimulus with an instrument, during a held contact."""

import math
from dataclasses import dataclass
from typing import Final, Literal, get_args

import numpy as np

from tactometry.arguments.require import one_of
from tactometry.session.answer import Rated, Touched
from tactometry.session.request import Enter

from .task import Presentation, Reply, Task, TaskKind, TrialCourse, TrialOutcome

QUESTION: Final = "vibrometer_nm"
LevelUnit = Literal["dB re 1 um", "m"]


@dataclass(frozen=True)
class Measurement(Task):
    """One stimulus, then the reading of a vibrometer in nm.

    The experimenter enters the reading, or it is simulated or recorded. The row contains it as `response` (nm) and as
    `level_measured` in the unit of the levels. A reading of 0 is below the resolution of the instrument and has no
    level in decibels.

    - `level_unit`: Unit of the stimulus, ``dB re 1 um`` or ``m``.
    """

    level_unit: LevelUnit = "dB re 1 um"

    name = "measurement"

    def __post_init__(self) -> None:
        one_of("Measurement.level_unit", self.level_unit, get_args(LevelUnit))

    def trial(self, shown: Presentation, rng: np.random.Generator) -> TrialCourse:
        del rng
        touch: Touched = yield shown.touch.request(shown.stimulus, shown.level, None)
        if not touch.valid:
            return TrialOutcome((touch,), touch)
        read: Rated = yield Enter(QUESTION, 0.0)
        answer = Reply(read, read.value, level_measured=level_of(read.value, self.level_unit))
        return TrialOutcome((touch,), touch, (answer,))


def level_of(nanometres: float | None, level_unit: str) -> float | None:
    """Convert a reading to the unit of the levels, or return None.

    >>> level_of(10e3, "dB re 1 um"), level_of(0.0, "dB re 1 um"), level_of(0.0, "m")
    (20.0, None, 0.0)
    """
    if nanometres is None or (nanometres == 0 and level_unit != "m"):
        return None
    return nanometres * 1e-9 if level_unit == "m" else round(20 * math.log10(nanometres / 1e3), 6)


TASK = TaskKind(Measurement)
