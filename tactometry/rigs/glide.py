"""The finger's way during one slide: collected, gated by its speed, and judged."""

import numpy as np

from tactometry.devices.position_sensor import FloatArray, PositionSensor, mean_speed_m_per_s
from tactometry.speed_gate import SpeedGate, motion

MOVING_S = 0.1
"""So long must a speed be kept before a stimulus begins: a turn of a fast finger is shorter (unverified default)."""
HALT_S = 0.15
"""A finger that is out of its band of speed for longer has stopped; a turn is shorter (unverified default)."""


class Glide:
    """Reads a sensor for one slide, whose path lies along its first axis; older samples are dropped."""

    def __init__(self, sensor: PositionSensor, gate: SpeedGate, now_s: float) -> None:
        sensor.read()
        self._sensor = sensor
        self._gate = gate
        self._times_s: list[float] = []
        self._positions_m: list[list[float]] = []
        self._moved_s = now_s

    @property
    def open(self) -> bool:
        """Whether the finger has moved at its speed long enough."""
        return self._gate.open

    def read(self) -> None:
        """Take in what the sensor has collected."""
        times_s, positions_m = self._sensor.read()
        for time_s, place_m in zip(times_s.tolist(), positions_m.tolist(), strict=True):
            self._gate = self._gate.after(time_s, place_m[0])
            self._moved_s = max(self._moved_s, time_s) if self._gate.moving else self._moved_s
        self._times_s += times_s.tolist()
        self._positions_m += positions_m.tolist()

    def stopped(self, now_s: float) -> bool:
        """Whether the finger has left its band of speed, or the sensor is silent."""
        return now_s - self._moved_s > HALT_S

    def in_band(self, begin_s: float, end_s: float) -> float | None:
        """The part of the time that the speed was in its band; None where it was not measured."""
        times_s, positions_m = self._between(begin_s, end_s)
        if times_s.size < 2:
            return None
        gate = self._gate
        return motion(times_s, positions_m[:, 0], gate.target_m_per_s, gate.tolerance).in_band

    def speed_m_per_s(self, begin_s: float, end_s: float) -> float | None:
        """The mean speed; None where it was not measured."""
        return mean_speed_m_per_s(*self._between(begin_s, end_s))

    def _between(self, begin_s: float, end_s: float) -> tuple[FloatArray, FloatArray]:
        """Finite samples of an interval, each later than the one before; none where stamps go back."""
        times_s = np.array(self._times_s)
        positions_m = np.array(self._positions_m, dtype=np.float64).reshape(len(times_s), -1)
        kept = (times_s >= begin_s) & (times_s <= end_s) & np.isfinite(positions_m).all(axis=1)
        times_s, positions_m = times_s[kept], positions_m[kept]
        whole = bool(np.all(np.diff(times_s) > 0))
        return (times_s, positions_m) if whole else (times_s[:0], positions_m[:0])
