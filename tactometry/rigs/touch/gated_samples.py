"""Force and motion of the finger during and between touches, gated and evaluated."""

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
"""A sensor that is silent for longer is lost."""
AWAY_PART = 0.1
"""Below this part of the target force the finger has left (unverified default)."""
MOVING_S = 0.1
"""Time for which a speed must be held before a stimulus; a turn of a fast finger is shorter (unverified default)."""
HALT_S = 0.15
"""A finger outside its speed band for longer has stopped; a turn is shorter (unverified default)."""
DEAF_S = 0.5
"""A sensor thread that sends no blocks for longer, not even empty ones, is held up (unverified default)."""


class Trace:
    """Collects sample blocks in one thread for another; `last_s` is the last stamp, `last` its value."""

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
            self._taken_s = min(now_s, self.last_s)  # a stamp may be ahead by an error of the clock offset
        self._told_s = now_s
        self._silent_s = 0.0 if times_s.size else now_s - self._taken_s

    def quiet(self, longest_s: float) -> bool:
        """Return True if nothing is known of the last `longest_s`; what waits in a held-up process does not count."""
        return self._silent_s > longest_s or time.perf_counter() - self._told_s > DEAF_S

    @property
    def age_s(self) -> float:
        """Age of the last sample, or of the trace."""
        return time.perf_counter() - self._taken_s

    def between(self, begin_s: float, end_s: float) -> tuple[FloatArray, FloatArray]:
        """Return times and values of finite samples of an interval; none if a stamp goes back."""
        blocks = self._blocks.copy()  # copied, as the sensor's thread may add blocks
        if not blocks:
            return np.empty(0), np.empty(0)
        times_s, values = (np.concatenate(parts) for parts in zip(*blocks, strict=True))
        finite = np.isfinite(values.reshape(len(values), -1)).all(axis=1)
        kept = (times_s >= begin_s) & (times_s <= end_s) & finite
        sound = bool(np.all(np.diff(times_s[kept]) >= 0))
        return (times_s[kept], values[kept]) if sound else (times_s[:0], values[:0])

    def mean_speed_m_per_s(self, begin_s: float, end_s: float) -> float | None:
        """Return the mean speed of positions; None if not measured."""
        times_s, positions_m = self.between(begin_s, end_s)
        return mean_speed_m_per_s(times_s, positions_m) if times_s.size else None


class GatedSamples(ABC, Generic[G]):
    """Passes the samples of one touch through a gate; `opened_s` is the stamp that opened it."""

    def __init__(self, gate: G) -> None:
        self.gate: G = gate
        """The gate after the last sample."""
        self.opened_s: float | None = None
        self._trace, self._heard_s = Trace(), time.perf_counter()
        self._good_s: float | None = None

    @property
    def open(self) -> bool:
        """True if the condition lasted long enough, by the sensor's stamps and by our clock.

        By our clock, samples that waited and came at once count from now. Requiring both may decide late, never early.
        """
        return self.gate.open and time.perf_counter() - self._heard_s >= self.gate.hold_s

    @abstractmethod
    def _is_good(self, value: float) -> bool:
        """Return True if playing may go on after this sample."""

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
                self._good_s = time_s  # the time also counts from a first sample that is not good

    def _is_bad_for(self, longest_s: float) -> bool:
        last_s, good_s = self._trace.last_s, self._good_s
        return last_s is not None and good_s is not None and last_s - good_s > longest_s


class AppliedForce(GatedSamples[ForceGate]):
    """Force of the finger; above `force_peak_n` playing stops."""

    def __init__(self, gate: ForceGate, force_peak_n: float = FORCE_PEAK_N) -> None:
        super().__init__(gate)
        self._force_peak_n = force_peak_n
        self.force_n: float | None = None
        """The last force, N; None before the first sample and after a lost one."""

    @property
    def open(self) -> bool:
        """True if the force was held long enough by both clocks, and is current."""
        return super().open and self._trace.age_s <= SILENT_S

    def _is_good(self, value: float) -> bool:
        self.force_n = value if math.isfinite(value) else None
        return self.force_n is not None

    @property
    def silent(self) -> bool:
        """True if the sensor sends nothing, or only lost samples."""
        return self._is_bad_for(SILENT_S) or self._trace.quiet(SILENT_S)

    @property
    def loss(self) -> Reason | None:
        """Why playing must stop: silent sensor, lifted finger, or excessive force; None if it may go on."""
        force_n = self.force_n
        if self.silent:
            return "sensor_lost"
        if force_n is None:
            return None
        if force_n > self._force_peak_n:
            return "too_heavy"
        return "lifted" if force_n < AWAY_PART * self.gate.target_n else None

    def compliance(self, begin_s: float, end_s: float) -> Compliance | None:
        """Return how well the force was kept; None without samples or if stamps go back."""
        times_s, forces_n = self._trace.between(begin_s, end_s)
        return compliance(times_s, forces_n, self.gate.target_n, self.gate.tolerance) if times_s.size else None


class FingerMotion(GatedSamples[SpeedGate]):
    """Motion of the finger along the sensor's first axis."""

    def _is_good(self, value: float) -> bool:
        return self.gate.moving

    @property
    def silent(self) -> bool:
        """True if the sensor sends no position, or only lost ones."""
        return self._trace.quiet(HALT_S) or self.gate.speed_m_per_s is None

    @property
    def loss(self) -> Reason | None:
        """Why playing must stop: speed out of band, or silent sensor; None if it may go on."""
        if self._trace.quiet(HALT_S):
            return "sensor_lost"
        if not self._is_bad_for(HALT_S):
            return None
        speed_m_per_s = self.gate.speed_m_per_s
        return "sensor_lost" if speed_m_per_s is None else fault_of_speed(speed_m_per_s, self.gate.target_m_per_s)

    def motion(self, begin_s: float, end_s: float) -> SpeedCompliance | None:
        """Return how well the speed was kept; None if it was not measured."""
        times_s, positions_m = self._trace.between(begin_s, end_s)
        if times_s.size < 2 or np.any(np.diff(times_s) == 0):  # two positions at one time have no speed
            return None
        return motion(times_s, positions_m[:, 0], self.gate.target_m_per_s, self.gate.tolerance)


class Release:
    """Check that the force left its band between touches.

    A stuck sensor never does. The force is received continuously; if not `needed`, `happened` is always true.
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
        """Forget the force so far, as a touch is over."""
        with self._lock:
            self._low_n, self._high_n = math.inf, -math.inf

    def happened(self, gate: ForceGate) -> bool:
        """Return True if the force was outside the band of a gate since `begin`."""
        with self._lock:
            known = self._low_n <= self._high_n
            # if both extremes are in the band, so are all samples
            stayed = gate.holds(self._low_n) and gate.holds(self._high_n)
            return not self._needed or (known and not stayed)
