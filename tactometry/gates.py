"""Gates for held force and speed, and compliance of touches."""

import math
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .arguments.constraints import NotNegative, Positive, constrained
from .arguments.require import expect, positive
from .errors import InvalidParameter

VALID_PART = 0.8
"""Fraction of a touch that must be in the band for a valid trial (unverified default)."""
WINDOW_S = 0.05
"""Window over which a speed is computed as displacement over duration (unverified default)."""

G = TypeVar("G")


def _then(gate: G, **state: Any) -> G:
    """Replace fields without checks, for speed: each sample creates a gate."""
    then: G = object.__new__(type(gate))
    vars(then).update(vars(gate), **state)
    return then


@dataclass(frozen=True)
@constrained
class ForceGate:
    """Gate that opens once a force was held long enough.

    Each sample creates a new gate. The hold restarts after a sample outside the band, a lost sample (NaN), a gap above
    `max_gap_s` or a decreasing time stamp. So the gate may open late, but never early.

    - `target_n`: Force to hold, N, above 0.
    - `tolerance`: Half width of the band relative to the target. The band includes its edges.
    - `hold_s`: Duration for which the force must be held, s.
    - `max_gap_s`: Longest interval between two samples of a hold, s.

    >>> gate = ForceGate(target_n=1.0, tolerance=0.2, hold_s=0.015)
    >>> for time_s, force_n in [(0.0, 0.5), (0.01, 0.9), (0.02, 1.1), (0.03, 1.0)]:
    ...     gate = gate.after(time_s, force_n)
    >>> gate.open, gate.after(0.04, float("nan")).open
    (True, False)
    """

    target_n: Positive
    tolerance: Positive
    hold_s: NotNegative
    max_gap_s: Positive = 0.02
    since_s: float | None = None
    last_s: float | None = None

    @property
    def open(self) -> bool:
        """True if the hold up to the last sample is long enough."""
        return self.since_s is not None and self.last_s is not None and self.last_s - self.since_s >= self.hold_s

    def holds(self, force_n: float) -> bool:
        """Return True if a force (N) is in the band. NaN is outside."""
        return abs(force_n - self.target_n) <= self.tolerance * self.target_n

    def after(self, sample_time_s: float, force_n: float) -> "ForceGate":
        """Return the gate after a sample (N) with its time stamp (s)."""
        if not (math.isfinite(sample_time_s) and self.holds(force_n)):
            return _then(self, since_s=None, last_s=None)
        follows = self.last_s is not None and 0 <= sample_time_s - self.last_s <= self.max_gap_s
        since_s = self.since_s if follows else sample_time_s
        return _then(self, since_s=since_s, last_s=sample_time_s)


class Compliance(NamedTuple):
    """Mean and spread of a force (N), and fraction (0..1) in the band."""

    mean_n: float
    sd_n: float
    in_band: float


def compliance(
    times_s: ArrayLike, forces_n: ArrayLike, target_n: float, tolerance: float, window_s: float = 0.25
) -> Compliance:
    """Return how well a force was kept.

    - `times_s`: Time stamps, s, never decreasing.
    - `forces_n`: Finite forces, N, at least one.
    - `target_n`, `tolerance`: Force band, as in `ForceGate`.
    - `window_s`: Length of the running mean, s.

    `sd_n` divides by n_samples; `in_band` is the fraction (0..1) of samples whose running mean is in the band.

    >>> compliance([0.0, 0.1, 0.2, 0.3], [1.0, 1.0, 2.0, 2.0], target_n=1.0, tolerance=0.25, window_s=0.1)
    Compliance(mean_n=1.5, sd_n=0.5, in_band=0.5)
    """
    positive("compliance", target_n=target_n, tolerance=tolerance, window_s=window_s)
    times, forces = stamped_samples("compliance", times_s, forces_n, "forces_n", rising=False)
    (kept,) = compliances(times, forces[None], target_n, tolerance, window_s)
    return kept


def compliances(
    times_s: NDArray[np.float64],
    forces_n: NDArray[np.float64],
    target_n: float,
    tolerance: float,
    window_s: float = 0.25,
) -> list[Compliance]:
    """Compute `compliance` of touches with the same time stamps, unchecked."""
    first = np.searchsorted(times_s, times_s - window_s, side="right")
    behind = np.arange(1, times_s.size + 1)
    first = np.minimum(first, behind - 1)  # a window shorter than any step contains its own sample
    # reduceat sums between consecutive edges, so every second sum is a window; the appended 0 allows an edge at the end
    edges = np.column_stack([first, behind]).ravel()
    ended = np.pad(forces_n, ((0, 0), (0, 1)))
    sums = np.add.reduceat(ended, edges, axis=1)[:, ::2]
    running_means = np.asarray(sums / (behind - first), dtype=np.float64)
    off_target_n = np.abs(running_means - target_n)
    in_band = (off_target_n <= tolerance * target_n).mean(axis=1)
    return list(map(Compliance, forces_n.mean(axis=1).tolist(), forces_n.std(axis=1).tolist(), in_band.tolist()))


def stamped_samples(
    owner: str, times_s: ArrayLike, values: ArrayLike, name: str, *, rising: bool
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return finite values with their time stamps (s), in order.

    Requires at least two `rising` stamps, or at least one stamp and none that decreases.

    Raises `InvalidParameter` otherwise. The message begins with `owner` and calls the values `name`.
    """
    times, samples = np.asarray(times_s, dtype=np.float64), np.asarray(values, dtype=np.float64)
    paired = times.ndim == 1 and times.shape == samples.shape and times.size >= 1 + rising
    sizes = f"{times.shape} stamps and {samples.shape} {name}"
    expect(paired, owner, sizes, f"equal numbers of both, at least {'two' if rising else 'one'}")
    for which, numbers in (("times_s", times), (name, samples)):
        finite = np.isfinite(numbers)
        if not finite.all():
            k = int(np.argmin(finite))
            raise InvalidParameter(
                f"{owner}.{which}[{k}]: found {numbers[k]}, expected a finite number; remove lost samples"
            )
    wrong = times[1:] <= times[:-1] if rising else times[1:] < times[:-1]
    if wrong.any():
        k = 1 + int(np.argmax(wrong))
        expected = "a later stamp" if rising else "no step back"
        raise InvalidParameter(f"{owner}.times_s[{k}]: found {times[k]} after {times[k - 1]}, expected {expected}")
    return times, samples


@dataclass(frozen=True)
@constrained
class SpeedGate:
    """Gate that is open while a finger moves at the target speed.

    Each sample creates a new gate. The speed is known once samples without a gap span half of `window_s`. The gate
    restarts after a lost sample (NaN), a gap above `max_gap_s` or a time stamp that does not increase. So the gate may
    open late, but never early.

    - `target_m_per_s`: Speed in either direction, m/s, above 0.
    - `tolerance`: Half width of the band relative to the target. The band includes its edges.
    - `hold_s`: Duration for which the speed must be kept, s.
    - `window_s`, `max_gap_s`: Window of the speed and longest interval between samples, s.

    >>> gate = SpeedGate(target_m_per_s=0.05, tolerance=0.2, hold_s=0.01, window_s=0.02)
    >>> for n in range(4):
    ...     gate = gate.after(sample_time_s=0.01 * n, position_m=0.0005 * n)
    >>> gate.open, gate.after(0.04, 0.0015).after(0.05, 0.0015).open
    (True, False)
    """

    target_m_per_s: Positive
    tolerance: Positive
    hold_s: NotNegative = 0.0
    window_s: Positive = WINDOW_S
    max_gap_s: Positive = 0.02
    samples: tuple[tuple[float, float], ...] = ()
    since_s: float | None = None

    @property
    def speed_m_per_s(self) -> float | None:
        """Current speed, m/s, at least 0, or None while unknown."""
        return self._speed_m_per_s(self.samples) if self.samples else None

    def _speed_m_per_s(self, samples: tuple[tuple[float, float], ...]) -> float | None:
        (begin_s, begin_m), (end_s, end_m) = samples[0], samples[-1]
        span_s = end_s - begin_s
        return None if span_s < self.window_s / 2 else abs(end_m - begin_m) / span_s

    @property
    def moving(self) -> bool:
        return self.since_s is not None

    @property
    def open(self) -> bool:
        """True if the motion up to the last sample is long enough."""
        return self.since_s is not None and self.samples[-1][0] - self.since_s >= self.hold_s

    def holds(self, speed_m_per_s: float | None) -> bool:
        """Return True if a speed (m/s) is known and in the band."""
        if speed_m_per_s is None:
            return False
        return abs(speed_m_per_s - self.target_m_per_s) <= self.tolerance * self.target_m_per_s

    def after(self, sample_time_s: float, position_m: float) -> "SpeedGate":
        """Return the gate after a position on the path (m) and its time stamp (s)."""
        if not (math.isfinite(sample_time_s) and math.isfinite(position_m)):
            return _then(self, samples=(), since_s=None)
        samples = self._window(sample_time_s, position_m)
        kept_s = sample_time_s if self.since_s is None else self.since_s
        return _then(self, samples=samples, since_s=kept_s if self.holds(self._speed_m_per_s(samples)) else None)

    def _window(self, sample_time_s: float, position_m: float) -> tuple[tuple[float, float], ...]:
        if not self.samples or not 0 < sample_time_s - self.samples[-1][0] <= self.max_gap_s:
            return ((sample_time_s, position_m),)
        begin_s = sample_time_s - self.window_s
        # stamps increase, so the first samples leave the window
        n_left = next((n for n, (time_s, _) in enumerate(self.samples) if time_s >= begin_s), len(self.samples))
        return (*self.samples[n_left:], (sample_time_s, position_m))


class SpeedCompliance(NamedTuple):
    """Mean speed (m/s) of a path, and fraction (0..1) in the band."""

    mean_m_per_s: float
    in_band: float


def motion(
    times_s: ArrayLike, positions_m: ArrayLike, target_m_per_s: float, tolerance: float, window_s: float = WINDOW_S
) -> SpeedCompliance:
    """Return how well a speed was kept. The mean is length over duration.

    - `times_s`: Increasing time stamps, s, at least two.
    - `positions_m`: Finite positions along the path, m.
    - `target_m_per_s`, `tolerance`: Speed band, as in `SpeedGate`.
    - `window_s`: Window around a sample over which its speed is computed, s.

    >>> motion([0.0, 0.1, 0.2, 0.3], [0.0, 0.01, 0.02, 0.02], 0.1, tolerance=0.2, window_s=0.2).in_band
    0.5
    """
    SpeedGate(target_m_per_s, tolerance, window_s=window_s)  # refuses an invalid band
    times, positions = stamped_samples("motion", times_s, positions_m, "positions_m", rising=True)
    (kept,) = motions(times, positions[None], target_m_per_s, tolerance, window_s)
    return kept


def motions(
    times_s: NDArray[np.float64],
    positions_m: NDArray[np.float64],
    target_m_per_s: float,
    tolerance: float,
    window_s: float = WINDOW_S,
) -> list[SpeedCompliance]:
    """Compute `motion` of touches with the same time stamps, unchecked."""
    speeds = speeds_m_per_s(times_s, positions_m, window_s)
    means_m_per_s = np.abs(np.diff(positions_m)).sum(axis=1) / (times_s[-1] - times_s[0])
    in_band = np.abs(speeds - target_m_per_s) <= tolerance * target_m_per_s * (1 + 1e-12)
    return list(map(SpeedCompliance, means_m_per_s.tolist(), in_band.mean(axis=1).tolist()))


def speeds_m_per_s(
    times_s: NDArray[np.float64], positions_m: NDArray[np.float64], window_s: float = WINDOW_S
) -> NDArray[np.float64]:
    """Return the speed at each sample, m/s, unchecked.

    >>> speeds_m_per_s(np.array([0.0, 0.1, 0.2]), np.array([0.0, 0.01, 0.02]), window_s=0.2).round(9).tolist()
    [0.1, 0.1, 0.1]
    """
    first, last = _windows(times_s, window_s)
    return np.asarray(np.abs(positions_m[..., last] - positions_m[..., first]) / (times_s[last] - times_s[first]))


def _windows(times_s: NDArray[np.float64], window_s: float) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the first and last sample of the window around each sample."""
    half_s = window_s / 2 * (1 + 1e-9)  # keep a sample at the very end of a window despite rounding
    first = np.searchsorted(times_s, times_s - half_s, side="left")
    last = np.searchsorted(times_s, times_s + half_s, side="right") - 1
    # a sample alone in its window is paired with the previous one, the first sample with the next
    alone = first == last
    last = np.where(alone & (first == 0), 1, last)
    return np.where(alone, np.maximum(first - 1, 0), first), last


def triangle(path_m: ArrayLike, length_m: float) -> NDArray[np.float64]:
    """Return the position (m) of a finger that moves out and back.

    >>> triangle([0.0, 0.05, 0.1, 0.15, 0.2], length_m=0.1).round(9).tolist()
    [0.0, 0.05, 0.1, 0.05, 0.0]
    """
    phase = np.asarray(path_m, dtype=np.float64) % (2 * length_m)
    return np.asarray(np.minimum(phase, 2 * length_m - phase), dtype=np.float64)
