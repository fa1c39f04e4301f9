"""The finger's way during one slide: collected, gated by its speed, and judged."""

import numpy as np

from ...devices.sensors.reader import FloatArray
from ...gates.speed import SpeedCompliance, SpeedGate, motion
from ...trials.trial import Reason
from ..judgement import side_of
from .trace import Since, Trace

MOVING_S = 0.1
"""So long must a speed be kept before a stimulus begins: a turn of a fast finger is shorter (unverified default)."""
HALT_S = 0.15
"""A finger that is out of its band of speed for longer has stopped; a turn is shorter (unverified default)."""


class FingerMotion:
    """Hears the samples of one slide; its path lies along the sensor's first axis.

    `opened_s` is the stamp of the sample that opened the gate.
    """

    def __init__(self, gate: SpeedGate) -> None:
        self._gate = gate
        self._trace, self._since = Trace(), Since()
        self._moved_s: float | None = None
        self.opened_s: float | None = None

    @property
    def open(self) -> bool:
        """Whether the finger has moved at its speed long enough, by the sensor's stamps and by our clock."""
        return self._gate.open and self._since.lasts(self._gate.hold_s)

    def hear(self, times_s: FloatArray, positions_m: FloatArray) -> None:
        self._trace.hear(times_s, positions_m)
        for time_s, place_m in zip(times_s.tolist(), positions_m.tolist(), strict=True):
            was_open = self._gate.open
            self._gate = self._gate.after(time_s, place_m[0])
            self._since.hear(self._gate.since_s)
            if self._gate.open and not was_open:
                self.opened_s = time_s
            if self._moved_s is None or self._gate.moving:
                self._moved_s = time_s  # a finger that never moves has `HALT_S` from the first sample on

    @property
    def loss(self) -> Reason | None:
        """Why nothing may play any more: the finger has left its band of speed, or the sensor is silent."""
        last_s, moved_s, speed_m_per_s = self._trace.last_s, self._moved_s, self._gate.speed_m_per_s
        if self._trace.quiet(HALT_S):
            return "sensor_lost"
        if last_s is None or moved_s is None or last_s - moved_s <= HALT_S:
            return None
        return "sensor_lost" if speed_m_per_s is None else side_of(speed_m_per_s, self._gate.target_m_per_s)

    def motion(self, begin_s: float, end_s: float) -> SpeedCompliance | None:
        """How the speed was kept; None where it was not measured."""
        times_s, positions_m = self._trace.between(begin_s, end_s)
        if times_s.size < 2 or np.any(np.diff(times_s) == 0):  # two places at one time have no speed
            return None
        gate = self._gate
        return motion(times_s, positions_m[:, 0], gate.target_m_per_s, gate.tolerance)
