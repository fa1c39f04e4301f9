"""Temporal summation of the Pacinian channel."""

from functools import lru_cache
from itertools import accumulate
from typing import Final

import numpy as np

from ..arrays import FloatArray, IntArray
from .channels import P, channel_thresholds_db

TAU_S: Final = 0.2
"""Time constant of the leaky integrator: 3 dB per doubling of a shorter duration, nothing above 1 s. Zwislocki (J.
Acoust. Soc. Am. 32, 1046, 1960), whose theory Verrillo (J. Acoust. Soc. Am. 37, 843, 1965) found to hold for
vibration on the hand; the number is from memory of these papers (`temporal_summation` in `stimuli/sources.toml`)."""

STEP_HZ: Final = 5.0
"""Spacing of the points of the sensitivity curve, which is linear between them."""

HORIZON_S: Final = 1 / STEP_HZ
"""Events further apart do not sum: `likeness` is 0 at this lag, and within 2e-4 of 0 beyond it."""


def summed_amplitude(times_s: FloatArray, peaks: FloatArray) -> float:
    """Return the amplitude of a single event that equals a train for channel P.

    Each event a_k at t_k passes the filter of P, and a leaky integrator of `TAU_S` sums the energy. After event n it is
    ``E_n = sum_jk a_j a_k R(t_j - t_k) exp(-(2 t_n - t_j - t_k)/(2 tau))``, R being `likeness`. The amplitude is the
    root of the largest E_n or a_n^2. It lies between the largest amplitude and the sum of all. Events too far apart to
    overlap add their squares.

    Parameters
    ----------
    times_s, peaks
        (n,): times of the events, in any order, and their amplitudes, at least 0.

    >>> far, near = (summed_amplitude(np.array([0.0, apart_s]), np.ones(2)) for apart_s in (1.0, 4e-3))
    >>> far < 1.004, near > 1.5
    (True, True)
    """
    order = np.argsort(times_s, kind="stable")
    largest = float(peaks.max())
    if largest == 0:
        return 0.0
    times, amplitudes = times_s[order], peaks[order] / largest  # the squares of the smallest would underflow
    later, sooner = _neighbours(times)
    lag_s = times[later] - times[sooner]
    shared = amplitudes[later] * amplitudes[sooner] * likeness(lag_s) * np.exp(-lag_s / (2 * TAU_S))
    gained = amplitudes**2 + 2 * np.bincount(later, shared, times.size)
    kept = np.exp(-np.diff(times, prepend=times[:1]) / TAU_S)
    steps = zip(kept, gained, strict=True)
    most = max(accumulate(steps, lambda energy, step: energy * step[0] + step[1], initial=0.0))
    return largest * max(float(np.sqrt(most)), 1.0)


def likeness(lag_s: FloatArray) -> FloatArray:
    """Return R, the autocorrelation of P's response at lags (s).

    ``integral of 10^(-T(f)/10) cos(2 pi f t) df`` with the threshold T of P, straight between points `STEP_HZ` apart,
    so that the integral is exact. A sum of cosines would be periodic in 1/`STEP_HZ`.

    >>> likeness(np.array([0.0, 2e-3, 0.1])).round(2).tolist()
    [1.0, -0.57, 0.0]
    """
    lines = np.polynomial.chebyshev.chebval(np.cos(2 * np.pi * STEP_HZ * lag_s), _power())  # sum of p_k cos(k x)
    return np.asarray(lines * np.sinc(STEP_HZ * lag_s) ** 2)


@lru_cache(maxsize=1)
def _power() -> FloatArray:
    """Return shares of the energy at multiples of `STEP_HZ`, from 0 Hz."""
    frequency_hz = np.arange(STEP_HZ, 1000.0, STEP_HZ)
    power = 10 ** (-channel_thresholds_db(frequency_hz)[P] / 10)
    return np.concatenate([[0.0], power / power.sum()])


def _neighbours(times_s: FloatArray) -> tuple[IntArray, IntArray]:
    """Return the later and earlier indices of event pairs within `HORIZON_S`."""
    index = np.arange(times_s.size)
    first = np.searchsorted(times_s, times_s - HORIZON_S)
    n_before = index - first
    later = np.repeat(index, n_before)
    before = np.arange(later.size) - np.repeat(np.cumsum(n_before) - n_before, n_before)
    return later, before + first[later]
