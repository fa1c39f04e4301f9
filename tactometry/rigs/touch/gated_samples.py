"""Gates for the finger's force and motion during and between touches."""

import math
import threading
import time
from abc import ABC, abstractmethod
from typing import Generic, TypeVar

import numpy as np

from ...devices.sensors.streamed import mean_speed_m_per_s
from ...gates import Compliance, ForceGate, SpeedCompliance, SpeedGate, compliance, motion
from ...safety.limits import FORCE_PEAK_N
from ...signal import FloatArray
from ...trials.trial import Reason
from ..touch_validity import fault_of_speed

G = TypeVar("G", ForceGate, SpeedGate)

SILENT_S = 0.1
"""A sensor is lost if it is silent for longer than this."""
AWAY_PART = 0.1
"""Below this fraction of the target force the finger has left (unverified default)."""
MOVING_S = 0.1
"""Duration for which the speed must stay in its band before a stimulus. It exceeds the turn of a fast finger
(unverified default)."""
HALT_S = 0.15
"""A finger outside its speed band for longer has stopped. It exceeds the duration of a turn (unverified default)."""
DEAF_S = 0.5
"""A sensor thread that sends no blocks for longer, not even empty ones, is blocked (unverified default)."""


class Trace:
    """Sample blocks, collected in one thread and read in another.

    `last_s` is the last time stamp, `last` its value.
    """

    def __init__(self) -> None:
        self._blocks: list[tuple[FloatArray, FloatArray]] = []
        self._told_s = self._taken_s = time.perf_counter()
        self._silent_s = 0.0
        self.last_s: float | None = None
        self.last: FloatArray | None = None

    def on_samples(self, times_s: FloatArray, values: FloatArray) -> None:
        now_s = time.perf_counter()
        if times_s.size:
            self._blocks.append((times_s, values))
            self.last_s, self.last = float(times_s[-1]), values[-1]
            self._taken_s = min(now_s, self.last_s)  # an error of the clock offset may put a stamp in the future
        self._told_s = now_s
        self._silent_s = 0.0 if times_s.size else now_s - self._taken_s

    def quiet(self, longest_s: float) -> bool:
        """Return True if the sensor sent no samples for `longest_s`.

        Time in which the process was blocked, so that samples waited, is not counted.
        """
        return self._silent_s > longest_s or time.perf_counter() - self._told_s > DEAF_S

    @property
    def age_s(self) -> float:
        """Age of the last sample, or of the trace if it is empty."""
        return time.perf_counter() - self._taken_s

    def between(self, begin_s: float, end_s: float) -> tuple[FloatArray, FloatArray]:
        """Return times and values of the finite samples in an interval.

        Returns none if a time stamp decreases.
        """
        blocks = self._blocks.copy()  # copied, as the sensor's thread may add blocks
        if not blocks:
            return np.empty(0), np.empty(0)
        times_s, values = (np.concatenate(parts) for parts in zip(*blocks, strict=True))
        finite = np.isfinite(values.reshape(len(values), -1)).all(axis=1)
        kept = (times_s >= begin_s) & (times_s <= end_s) & finite
        sound = bool(np.all(np.diff(times_s[kept]) >= 0))
        return (times_s[kept], values[kept]) if sound else (times_s[:0], values[:0])

    def mean_speed_m_per_s(self, begin_s: float, end_s: float) -> float | None:
        """Return the mean speed of the positions, or None if not measured."""
        times_s, positions_m = self.between(begin_s, end_s)
        return mean_speed_m_per_s(times_s, positions_m) if times_s.size else None


class GatedSamples(ABC, Generic[G]):
    """Samples of one touch, passed through a gate.

    `opened_s` is the time stamp that opened the gate.
    """

    def __init__(self, gate: G) -> None:
        self.gate: G = gate
        """Gate after the last sample."""
        self.opened_s: float | None = None
        self._trace, self._heard_s = Trace(), time.perf_counter()
        self._good_s: float | None = None

    @property
    def open(self) -> bool:
        """Return True if the condition lasted long enough by both clocks.

        The clocks are the sensor's time stamps and our own clock, which counts delayed samples from their arrival.
        Requiring both may make the decision late, but never early.
        """
        return self.gate.open and time.perf_counter() - self._heard_s >= self.gate.hold_s

    @abstractmethod
    def _is_good(self, value: float) -> bool:
        """Return True if playback may continue after this sample."""

    def on_samples(self, times_s: FloatArray, values: FloatArray) -> None:
        self._trace.on_samples(times_s, values)
        along = values if values.ndim == 1 else values[:, 0]  # the first axis of positions
        for time_s, value in zip(times_s.tolist(), along.tolist(), strict=True):
            before, self.gate = self.gate, self.gate.after(time_s, value)
            if self.gate.since_s != before.since_s:
                self._heard_s = time.perf_counter()
            if self.gate.open and not before.open:
                self.opened_s = time_s
            if self._is_good(value) or self._good_s is None:
                self._good_s = time_s  # a first sample that is not good also starts the time

    def _is_bad_for(self, longest_s: float) -> bool:
        last_s, good_s = self._trace.last_s, self._good_s
        return last_s is not None and good_s is not None and last_s - good_s > longest_s


class AppliedForce(GatedSamples[ForceGate]):
    """Force of the finger. Above `force_peak_n` playback stops."""

    def __init__(self, gate: ForceGate, force_peak_n: float = FORCE_PEAK_N) -> None:
        super().__init__(gate)
        self._force_peak_n = force_peak_n
        self.force_n: float | None = None
        """Last force, N; None before the first sample and after a lost one."""

    @property
    def open(self) -> bool:
        """Return True if the force was held long enough and is current."""
        return super().open and self._trace.age_s <= SILENT_S

    def _is_good(self, value: float) -> bool:
        self.force_n = value if math.isfinite(value) else None
        return self.force_n is not None

    @property
    def silent(self) -> bool:
        """Return True if the sensor sends nothing, or only lost samples."""
        return self._is_bad_for(SILENT_S) or self._trace.quiet(SILENT_S)

    @property
    def loss(self) -> Reason | None:
        """Return why playback must stop (sensor, finger or force), or None."""
        force_n = self.force_n
        if self.silent:
            return "sensor_lost"
        if force_n is None:
            return None
        if force_n > self._force_peak_n:
            return "too_heavy"
        return "lifted" if force_n < AWAY_PART * self.gate.target_n else None

    def compliance(self, begin_s: float, end_s: float) -> Compliance | None:
        """Return how well the force was kept, or None without valid samples."""
        times_s, forces_n = self._trace.between(begin_s, end_s)
        return compliance(times_s, forces_n, self.gate.target_n, self.gate.tolerance) if times_s.size else None


class FingerMotion(GatedSamples[SpeedGate]):
    """Motion of the finger along the first axis of the position sensor."""

    def _is_good(self, value: float) -> bool:
        return self.gate.moving

    @property
    def silent(self) -> bool:
        """Return True if the sensor sends no position, or only lost ones."""
        return self._trace.quiet(HALT_S) or self.gate.speed_m_per_s is None

    @property
    def loss(self) -> Reason | None:
        """Return why playback must stop (speed or sensor), or None."""
        if self._trace.quiet(HALT_S):
            return "sensor_lost"
        if not self._is_bad_for(HALT_S):
            return None
        speed_m_per_s = self.gate.speed_m_per_s
        return "sensor_lost" if speed_m_per_s is None else fault_of_speed(speed_m_per_s, self.gate.target_m_per_s)

    def motion(self, begin_s: float, end_s: float) -> SpeedCompliance | None:
        """Return how well the speed was kept, or None if it was not measured."""
        times_s, positions_m = self._trace.between(begin_s, end_s)
        if times_s.size < 2 or np.any(np.diff(times_s) == 0):  # two positions with the same time stamp have no speed
            return None
        return motion(times_s, positions_m[:, 0], self.gate.target_m_per_s, self.gate.tolerance)


class Release:
    """Check that the force left its band between touches.

    With a stuck sensor it never does. The force is received continuously. If the check is not `needed`, `happened`
    is always true.
    """

    def __init__(self, *, needed: bool = True) -> None:
        self._needed = needed
        self._lock = threading.Lock()
        self._low_n, self._high_n = math.inf, -math.inf

    def on_samples(self, times_s: FloatArray, forces_n: FloatArray) -> None:
        del times_s
        known_n = [force_n for force_n in forces_n.tolist() if math.isfinite(force_n)]
        with self._lock:
            self._low_n = min(self._low_n, *known_n, math.inf)
            self._high_n = max(self._high_n, *known_n, -math.inf)

    def begin(self) -> None:
        """Discard the force so far, because a touch is over."""
        with self._lock:
            self._low_n, self._high_n = math.inf, -math.inf

    def happened(self, gate: ForceGate) -> bool:
        """Return True if the force was outside the band of a gate since `begin`."""
        with self._lock:
            known = self._low_n <= self._high_n
            # if both extremes are in the band, so are all samples
            stayed = gate.holds(self._low_n) and gate.holds(self._high_n)
            return not self._needed or (known and not stayed)
