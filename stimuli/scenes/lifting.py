"""Where a contact pulls by more than it is pressed with: a finger would lift off there, and the linear one does not."""

import math
from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray
from .plan import Plan, Result

FORCE, MOVED = "contact_force_n", "motion"


@dataclass(frozen=True)
class PulledFinger:
    """A finger of a scene, the force (N) that presses it, by which the plate pulls it at most, at a voltage (V)."""

    finger: int
    force_n: float
    pull_n: float
    voltage_v: float

    @property
    def lifts_off(self) -> bool:
        return self.pull_n > self.force_n

    @property
    def first_db_re_1v(self) -> float:
        """The voltage at which a linear contact would begin to pull, in dB re 1 V."""
        first_v = abs(self.voltage_v) * self.force_n / self.pull_n if self.pull_n else math.inf
        return 20 * math.log10(first_v)

    @property
    def line(self) -> str:
        """In one sentence.

        >>> PulledFinger(1, 2.0, 0.5, 10.0).line
        'finger 1 stays: at 20 dB re 1 V the plate would pull it by 0.5 N, and 2 N press it'
        """
        at = f"at {20 * math.log10(abs(self.voltage_v)):.3g} dB re 1 V" if self.voltage_v else "at 0 V"
        pulled = f"{at} the plate would pull it by {self.pull_n:.2g} N, and {self.force_n:g} N press it"
        if not self.lifts_off:
            return f"finger {self.finger} stays: {pulled}"
        return f"finger {self.finger} lifts off: {pulled}; contact is lost from {self.first_db_re_1v:.3g} dB re 1 V on"


def loads_n(plan: Plan) -> FloatArray:
    """(n_contacts,): the forces that press the fingers, in the order of the rows of ``contact_force_n``."""
    loads = (stage.settings for stage in plan.stages if stage.gives == MOVED and "force_n" in stage.settings)
    return np.asarray(next(loads, {}).get("force_n", ()), float)


def is_linear(plan: Plan) -> bool:
    """Whether the plate moves in proportion to the voltage: not where a contact opens and closes by it."""
    return not any(stage.gives == MOVED and "voltage_v" in stage.needs for stage in plan.stages)


def pulled_fingers(result: Result) -> list[PulledFinger]:
    """The fingers of which a result has the force of a linear contact; none without it."""
    if FORCE not in result.values or not is_linear(result.plan):
        return []
    lowest = np.atleast_2d(result.values[FORCE]).min(axis=1)
    pressed = zip(loads_n(result.plan), lowest, strict=True)
    return [
        PulledFinger(n, float(force_n), max(-float(least), 0.0), result.given["voltage_v"])
        for n, (force_n, least) in enumerate(pressed, 1)
    ]
