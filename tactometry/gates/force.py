"""When a finger has held a force long enough, and how well it kept it: decided on sample stamps."""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..arguments.require import not_negative, positive
from ..errors import InvalidParameter


@dataclass(frozen=True)
class ForceGate:
    """Opens once `target_n` was held within `tolerance` for `hold_s`, with no gap between the samples.

    Each sample makes a new gate. The hold starts again after a sample outside the band, a lost sample (NaN),
    a gap above `max_gap_s` and a stamp that goes back: the gate may open late, never early.

    Parameters
    ----------
    target_n : float
        The force to hold, N, above 0.
    tolerance : float
        Half width of the band relative to `target_n`, above 0; the band holds its edges.
    hold_s : float
        How long the force must be held, s, at least 0.
    max_gap_s : float
        The longest interval between samples that is still one hold, s, above 0.

    Raises
    ------
    InvalidParameter
        If a value is not as stated.

    Examples
    --------
    >>> gate = ForceGate(target_n=1.0, tolerance=0.2, hold_s=0.015)
    >>> for time_s, force_n in [(0.0, 0.5), (0.01, 0.9), (0.02, 1.1), (0.03, 1.0)]:
    ...     gate = gate.after(time_s, force_n)
    >>> gate.open, gate.after(0.04, float("nan")).open
    (True, False)
    """

    target_n: float
    tolerance: float
    hold_s: float
    max_gap_s: float = 0.02
    since_s: float | None = None
    last_s: float | None = None

    def __post_init__(self) -> None:
        positive("ForceGate", target_n=self.target_n, tolerance=self.tolerance, max_gap_s=self.max_gap_s)
        not_negative("ForceGate", hold_s=self.hold_s)

    @property
    def open(self) -> bool:
        """Whether the hold that reaches to the last sample is long enough."""
        return self.since_s is not None and self.last_s is not None and self.last_s - self.since_s >= self.hold_s

    def holds(self, force_n: float) -> bool:
        """Whether a force (N) is in the band; a NaN is not."""
        return abs(force_n - self.target_n) <= self.tolerance * self.target_n

    def after(self, sample_time_s: float, force_n: float) -> "ForceGate":
        """The gate after a sample of `force_n` (N) stamped `sample_time_s` (s)."""
        if not (math.isfinite(sample_time_s) and self.holds(force_n)):
            return replace(self, since_s=None, last_s=None)
        since_s = self.since_s if self._follows(sample_time_s) else sample_time_s
        return replace(self, since_s=since_s, last_s=sample_time_s)

    def _follows(self, sample_time_s: float) -> bool:
        return self.last_s is not None and 0 <= sample_time_s - self.last_s <= self.max_gap_s


VALID_PART = 0.8
"""The part of a touch that must be in the band for a valid trial (unverified default)."""


class Compliance(NamedTuple):
    """Mean and standard deviation of a force (N), and the part of the time (0..1) that it was in the band."""

    mean_n: float
    sd_n: float
    in_band: float


def compliance(
    times_s: ArrayLike, forces_n: ArrayLike, target_n: float, tolerance: float, window_s: float = 0.25
) -> Compliance:
    """How well a force was kept.

    Parameters
    ----------
    times_s : (n_samples,) array_like
        Stamps, s, never going back.
    forces_n : (n_samples,) array_like
        Finite forces, N; at least one.
    target_n, tolerance : float
        The band, as in `ForceGate`.
    window_s : float
        Length of the running mean, s: at each sample the mean of the samples of the last `window_s`, or of as
        many as there are.

    Returns
    -------
    Compliance
        `sd_n` is that of the trace (division by n_samples). `in_band` (0..1) is the part of the samples whose
        running mean lies in the band.

    Raises
    ------
    InvalidParameter
        If a value or a shape is not as stated.

    Examples
    --------
    >>> compliance([0.0, 0.1, 0.2, 0.3], [1.0, 1.0, 2.0, 2.0], target_n=1.0, tolerance=0.25, window_s=0.1)
    Compliance(mean_n=1.5, sd_n=0.5, in_band=0.5)
    """
    positive("compliance", target_n=target_n, tolerance=tolerance, window_s=window_s)
    times, forces = stamped_samples("compliance", times_s, forces_n, "forces_n", rising=False)
    off_target_n = np.abs(_running_mean(times, forces, window_s) - target_n)
    in_band = off_target_n <= tolerance * target_n
    return Compliance(float(forces.mean()), float(forces.std()), float(in_band.mean()))


def _running_mean(times_s: NDArray[np.float64], forces_n: NDArray[np.float64], window_s: float) -> NDArray[np.float64]:
    first = np.searchsorted(times_s, times_s - window_s, side="right")
    behind = np.arange(1, times_s.size + 1)
    first = np.minimum(first, behind - 1)  # a window that rounding makes shorter than any step holds its own sample
    # reduceat sums from each edge to the next: every second sum is a window's; the 0 lets the last edge be the end
    edges = np.column_stack([first, behind]).ravel()
    sums = np.add.reduceat(np.append(forces_n, 0.0), edges)[::2]
    return np.asarray(sums / (behind - first), dtype=np.float64)


def stamped_samples(
    owner: str, times_s: ArrayLike, values: ArrayLike, name: str, *, rising: bool
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Finite values with their stamps (s): at least two that rise, or at least one with none that goes back.

    Raises
    ------
    InvalidParameter
        If they are none; `owner` opens the sentence, which calls the values by their `name`.
    """
    times, samples = np.asarray(times_s, dtype=np.float64), np.asarray(values, dtype=np.float64)
    if times.ndim != 1 or times.shape != samples.shape or times.size < 1 + rising:
        raise InvalidParameter(
            f"{owner}: found {times.shape} stamps and {samples.shape} {name}, expected as many of both, at least "
            f"{'two' if rising else 'one'}"
        )
    for which, found in (("times_s", times), (name, samples)):
        if not np.isfinite(found).all():
            k = int(np.argmin(np.isfinite(found)))
            raise InvalidParameter(
                f"{owner}.{which}[{k}]: found {found[k]}, expected a finite number; leave lost samples out"
            )
    wrong = np.diff(times) <= 0 if rising else np.diff(times) < 0
    if wrong.any():
        k = int(np.argmax(wrong)) + 1
        expected = "a later stamp" if rising else "no step back"
        raise InvalidParameter(f"{owner}.times_s[{k}]: found {times[k]} after {times[k - 1]}, expected {expected}")
    return times, samples
