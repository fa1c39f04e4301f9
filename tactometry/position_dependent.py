"""Signals that depend on the position of a moving finger."""

import hashlib
import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final, Protocol, runtime_checkable

import numpy as np

from .arguments.require import positive
from .gates import triangle
from .signal import FloatArray, Signal, Stimulus

N_KEPT: Final = 2**14
"""Largest number of samples of a path that are kept. Drivers need only recent samples."""
HELD_S: Final = 0.1
"""Duration for which the last position remains valid. After it the position is unknown (unverified default)."""


@runtime_checkable
class FollowsFinger(Stimulus, Protocol):
    """Stimulus whose signal is weakened by the position of a finger.

    Between two samples, the factor changes by at most their interval over `rise_s`.
    """

    @property
    def rise_s(self) -> float: ...

    def parts(self, x_m: FloatArray, before: Any = None) -> tuple[FloatArray, Any]:
        """Return factors (0..1) of the voltage at positions, and a state.

        The state is the `before` of the next call. The factor is 0 where a position is NaN.
        """

    def check_motion(self, speed_m_per_s: float, positions_hz: float | None = None) -> None:
        """Refuse a speed too high for the carrier or the rate of positions."""


class FingerPath:
    """Recent path of a finger along its first axis, shared by threads.

    >>> path = FingerPath()
    >>> path.on_samples(np.array([0.0, 0.1]), np.array([[0.0, 5.0], [0.01, 5.0]]))
    >>> path.at(np.array([-0.1, 0.05, 0.15, 0.3])).tolist()
    [nan, 0.005, 0.01, nan]
    """

    def __init__(self) -> None:
        self._kept: tuple[FloatArray, FloatArray, int] = np.empty(N_KEPT), np.empty(N_KEPT), 0
        """Times, positions and their number. Existing entries never change, so that another thread may read them."""
        self.last_s = -math.inf
        """Last time stamp; minus infinity before the first."""

    def on_samples(self, times_s: FloatArray, positions_m: FloatArray) -> None:
        """Add samples with time stamps (s), except lost or late ones."""
        for time_s, place_m in zip(times_s.tolist(), positions_m[:, 0].tolist(), strict=True):
            if time_s > self.last_s and math.isfinite(place_m):
                kept_s, kept_m, n = self._kept
                if n == N_KEPT:  # copy the recent half to new arrays
                    old_s, old_m, n = kept_s, kept_m, N_KEPT // 2
                    kept_s, kept_m = np.empty(N_KEPT), np.empty(N_KEPT)
                    kept_s[:n], kept_m[:n] = old_s[-n:], old_m[-n:]
                kept_s[n], kept_m[n] = time_s, place_m
                self._kept, self.last_s = (kept_s, kept_m, n + 1), time_s

    def at(self, times_s: FloatArray) -> FloatArray:
        """Return positions (m) at times (s), or NaN where unknown."""
        all_s, all_m, n = self._kept
        if not n:
            return np.full(times_s.shape, np.nan)
        kept_s, kept_m = all_s[:n], all_m[:n]
        known = (times_s >= kept_s[0]) & (times_s <= kept_s[-1] + HELD_S)
        return np.where(known, np.interp(times_s, kept_s, kept_m), np.nan)


@dataclass(frozen=True, eq=False)
class FollowedSignal(Signal):
    """Strongest samples of a stimulus, with the path of the finger."""

    stimulus: FollowsFinger
    path: FingerPath

    def __post_init__(self) -> None:
        super().__post_init__()
        positive("FollowedSignal", rise_s=self.stimulus.rise_s)

    @cached_property
    def _digest(self) -> str:
        """Return a digest unlike that of the samples, as caches must not mix them."""
        strongest = Signal(self.samples, self.rate_hz, self.unit).digest()
        return hashlib.sha256(f"{strongest} under a finger, {self.stimulus.rise_s!r}".encode()).hexdigest()[:16]


@dataclass(frozen=True)
class PlayedPath:
    """Signal emitted under a moving finger.

    - `signal`: Emitted signal.
    - `latency_s`: Time from a position to the voltage that depends on it.
    - `late`, `unknown`: Fractions (0..1) of samples whose position arrived late, or was unknown.
    """

    signal: Signal
    latency_s: float
    late: float
    unknown: float


def felt_under(stimulus: Stimulus, signal: Signal, times_s: FloatArray, positions_m: FloatArray) -> Signal:
    """Return the signal that is emitted under a finger on this path."""
    if not isinstance(stimulus, FollowsFinger):
        return signal
    at_s = np.arange(signal.samples.shape[1]) / signal.rate_hz
    parts, _ = stimulus.parts(np.interp(at_s, times_s, positions_m))
    return Signal(signal.samples * parts, signal.rate_hz, signal.unit)


def straight_way(duration_s: float, speed_m_per_s: float, length_m: float) -> tuple[FloatArray, FloatArray]:
    """Return times (s) and positions (m) of a finger at constant speed.

    >>> straight_way(3.0, 0.1, 0.1)[1].round(9).tolist()
    [0.0, 0.1, 0.0, 0.1]
    """
    turns_s = np.arange(0.0, duration_s, length_m / speed_m_per_s) if speed_m_per_s else np.zeros(1)
    times_s = np.append(turns_s, duration_s)
    return times_s, triangle(speed_m_per_s * times_s, length_m)


def path_lines(times_s: FloatArray, positions_m: FloatArray) -> bytes:
    """Format times and positions as lines, to 1 us and 1 nm.

    >>> path_lines(np.array([0.001]), np.array([0.05]))
    b'0.001000\\t0.050000000\\n'
    """
    pairs = zip(times_s.tolist(), positions_m.tolist(), strict=True)
    return "".join(f"{time_s:.6f}\t{position_m:.9f}\n" for time_s, position_m in pairs).encode()
