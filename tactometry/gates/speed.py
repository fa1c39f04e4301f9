"""When a finger has moved at a speed long enough, and how well it kept it: decided on stamped positions."""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..arguments.require import not_negative, positive
from .force import stamped_samples

WINDOW_S = 0.05
"""A speed is the way between the ends of a window of this length over its duration (unverified default)."""


@dataclass(frozen=True)
class SpeedGate:
    """Open while the finger has moved at `target_m_per_s` within `tolerance` for `hold_s`, without a gap.

    Each sample makes a new gate. The speed is known once the samples without a gap span at least half of `window_s`;
    a lost sample (NaN), a gap above `max_gap_s` and a stamp that does not advance begin anew: the gate may open late,
    never early.

    Parameters
    ----------
    target_m_per_s : float
        The speed, m/s, above 0; its sign does not count.
    tolerance : float
        Half width of the band relative to the target, above 0; the band holds its edges.
    hold_s : float
        How long the speed must be kept, s, at least 0.
    window_s, max_gap_s : float
        Window of the speed and longest interval between samples, s, above 0.

    Raises
    ------
    InvalidParameter
        If a value is not as stated.

    Examples
    --------
    >>> gate = SpeedGate(target_m_per_s=0.05, tolerance=0.2, hold_s=0.01, window_s=0.02)
    >>> for n in range(4):
    ...     gate = gate.after(sample_time_s=0.01 * n, position_m=0.0005 * n)
    >>> gate.open, gate.after(0.04, 0.0015).after(0.05, 0.0015).open
    (True, False)
    """

    target_m_per_s: float
    tolerance: float
    hold_s: float = 0.0
    window_s: float = WINDOW_S
    max_gap_s: float = 0.02
    samples: tuple[tuple[float, float], ...] = ()
    since_s: float | None = None

    def __post_init__(self) -> None:
        positive("SpeedGate", target_m_per_s=self.target_m_per_s, tolerance=self.tolerance)
        positive("SpeedGate", window_s=self.window_s, max_gap_s=self.max_gap_s)
        not_negative("SpeedGate", hold_s=self.hold_s)

    @property
    def speed_m_per_s(self) -> float | None:
        """The present speed, m/s, at least 0; None while it is not known."""
        if not self.samples or self._span_s < self.window_s / 2:
            return None
        return abs(self.samples[-1][1] - self.samples[0][1]) / self._span_s

    @property
    def _span_s(self) -> float:
        return self.samples[-1][0] - self.samples[0][0]

    @property
    def moving(self) -> bool:
        """Whether the present speed is known and in the band."""
        return self.since_s is not None

    @property
    def open(self) -> bool:
        """Whether the motion that reaches to the last sample is long enough."""
        return self.since_s is not None and self.samples[-1][0] - self.since_s >= self.hold_s

    def holds(self, speed_m_per_s: float | None) -> bool:
        """Whether a speed (m/s) is known and in the band."""
        if speed_m_per_s is None:
            return False
        return abs(speed_m_per_s - self.target_m_per_s) <= self.tolerance * self.target_m_per_s

    def after(self, sample_time_s: float, position_m: float) -> "SpeedGate":
        """The gate after a sample of the place along the path (m) stamped `sample_time_s` (s)."""
        if not (math.isfinite(sample_time_s) and math.isfinite(position_m)):
            return replace(self, samples=(), since_s=None)
        moved = replace(self, samples=self._window(sample_time_s, position_m))
        if not moved.holds(moved.speed_m_per_s):
            return replace(moved, since_s=None)
        since_s = sample_time_s if self.since_s is None else self.since_s
        return replace(moved, since_s=since_s)

    def _window(self, sample_time_s: float, position_m: float) -> tuple[tuple[float, float], ...]:
        if not self.samples or not 0 < sample_time_s - self.samples[-1][0] <= self.max_gap_s:
            return ((sample_time_s, position_m),)
        kept = (sample for sample in self.samples if sample[0] >= sample_time_s - self.window_s)
        return (*kept, (sample_time_s, position_m))


class SpeedCompliance(NamedTuple):
    """Mean speed (m/s) of a path, and the part of the time (0..1) that the speed was in the band."""

    mean_m_per_s: float
    in_band: float


def motion(
    times_s: ArrayLike, positions_m: ArrayLike, target_m_per_s: float, tolerance: float, window_s: float = WINDOW_S
) -> SpeedCompliance:
    """How well a speed was kept.

    Parameters
    ----------
    times_s : (n_samples,) array_like
        Stamps, s, each later than the one before; at least two.
    positions_m : (n_samples,) array_like
        Finite places along the path, m.
    target_m_per_s, tolerance : float
        The band, as in `SpeedGate`.
    window_s : float
        The speed at a sample is the way between the ends of a window of this length around it, over its duration.

    Returns
    -------
    SpeedCompliance
        The mean is the length of the path over its duration.

    Raises
    ------
    InvalidParameter
        If a value or a shape is not as stated.

    Examples
    --------
    >>> motion([0.0, 0.1, 0.2, 0.3], [0.0, 0.01, 0.02, 0.02], 0.1, tolerance=0.2, window_s=0.2).in_band
    0.5
    """
    gate = SpeedGate(target_m_per_s, tolerance, window_s=window_s)
    times, positions = stamped_samples("motion", times_s, positions_m, "positions_m", rising=True)
    half_s = window_s / 2 * (1 + 1e-9)  # a sample at the very end of a window stays in it whatever rounding does
    first = np.searchsorted(times, times - half_s, side="left")
    last = np.searchsorted(times, times + half_s, side="right") - 1
    # a sample alone in its window has no speed: with the one before it, and the first of all with the one after
    alone = first == last
    last = np.where(alone & (first == 0), 1, last)
    first = np.where(alone, np.maximum(first - 1, 0), first)
    speeds = np.abs(positions[last] - positions[first]) / (times[last] - times[first])
    mean_m_per_s = float(np.abs(np.diff(positions)).sum() / (times[-1] - times[0]))
    in_band = np.abs(speeds - gate.target_m_per_s) <= tolerance * gate.target_m_per_s * (1 + 1e-12)
    return SpeedCompliance(mean_m_per_s, float(in_band.mean()))


def triangle(path_m: ArrayLike, length_m: float) -> NDArray[np.float64]:
    """The place (m, 0..`length_m`) of a finger that goes out and back, after a path of so many metres.

    >>> triangle([0.0, 0.05, 0.1, 0.15, 0.2], length_m=0.1).round(9).tolist()
    [0.0, 0.05, 0.1, 0.05, 0.0]
    """
    phase = np.asarray(path_m, dtype=np.float64) % (2 * length_m)
    return np.asarray(np.minimum(phase, 2 * length_m - phase), dtype=np.float64)
