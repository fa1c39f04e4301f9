"""What a sensor told during one touch."""

import time

import numpy as np

from ...devices.sensors.reader import FloatArray
from ...devices.sensors.streamed import mean_speed_m_per_s

DEAF_S = 0.5
"""A sensor's thread that tells nothing for longer, not even that nothing came, is held up (unverified default)."""


class Trace:
    """Collects blocks in one thread, and gives them to another; `last_s` is the last stamp, `last` its value."""

    def __init__(self) -> None:
        self._blocks: list[tuple[FloatArray, FloatArray]] = []
        self._told_s = self._taken_s = time.perf_counter()
        self._silent_s = 0.0
        self.last_s: float | None = None
        self.last: FloatArray | None = None

    def hear(self, times_s: FloatArray, values: FloatArray) -> None:
        now_s = time.perf_counter()
        if times_s.size:
            self._blocks.append((times_s, values))
            self.last_s, self.last = float(times_s[-1]), values[-1]
            self._taken_s = min(now_s, self.last_s)  # a stamp may be ahead of us by an error of the clocks
        self._told_s = now_s
        self._silent_s = 0.0 if times_s.size else now_s - self._taken_s

    def quiet(self, longest_s: float) -> bool:
        """Whether nothing is known of longer. What waits to be read while the process is held up is no silence."""
        return self._silent_s > longest_s or time.perf_counter() - self._told_s > DEAF_S

    @property
    def age_s(self) -> float:
        """How long ago the last sample was taken, or the trace begun."""
        return time.perf_counter() - self._taken_s

    def between(self, begin_s: float, end_s: float) -> tuple[FloatArray, FloatArray]:
        """Times and values of the finite samples of an interval; none where a stamp goes back."""
        blocks = self._blocks.copy()  # the sensor's thread adds to them meanwhile
        if not blocks:
            return np.empty(0), np.empty(0)
        times_s, values = (np.concatenate(parts) for parts in zip(*blocks, strict=True))
        finite = np.isfinite(values.reshape(len(values), -1)).all(axis=1)
        kept = (times_s >= begin_s) & (times_s <= end_s) & finite
        sound = bool(np.all(np.diff(times_s[kept]) >= 0))
        return (times_s[kept], values[kept]) if sound else (times_s[:0], values[:0])


class Since:
    """How long we have heard of something that a sensor's stamps say began: a second opinion, by our own clock.

    Samples that waited and came at once were heard of only now: what needs both opinions is late at most, never early.
    """

    def __init__(self) -> None:
        self._began_s: float | None = None
        self._heard_s = time.perf_counter()

    def hear(self, began_s: float | None) -> None:
        """It began at this stamp; None where it is over."""
        if began_s != self._began_s:
            self._began_s, self._heard_s = began_s, time.perf_counter()

    def lasts(self, longest_s: float) -> bool:
        return self._began_s is not None and time.perf_counter() - self._heard_s >= longest_s


def speed_m_per_s(places: Trace, begin_s: float, end_s: float) -> float | None:
    """The mean speed of positions; None where it was not measured."""
    times_s, positions_m = places.between(begin_s, end_s)
    return mean_speed_m_per_s(times_s, positions_m) if times_s.size else None
