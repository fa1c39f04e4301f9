"""Detection of a vibration by its component furthest above threshold."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments.require import not_negative_array, positive
from tactometry.errors import InvalidParameter

from ..arrays import FloatArray

SCALE_DB = 62.0
PER_HZ = 1 / 550
OFFSET = 6 / 11
DEPTH_DB = 77.0


def sensitivity_db(frequency_hz: ArrayLike) -> FloatArray:
    """Threshold amplitude (dB re the best one, at 250 Hz), of the shape of `frequency_hz` (Hz, at least 0).

    ``T(f) = |62 log10(f/550 + 6/11)^2/log10(6/11)^2| - 77``, capped at 0, less T(250) = -77: a shape that is
    published as code of a vibrotactile codec; it is reliable as a formula, weak as physiology.

    Raises
    ------
    InvalidParameter
        If a frequency is negative or not finite.

    >>> sensitivity_db([0, 40, 100, 250, 500, 1000]).round(2).tolist()
    [62.0, 39.04, 17.11, 0.0, 23.69, 77.0]
    """
    f_hz = not_negative_array("frequency_hz", frequency_hz)
    bowl_db: FloatArray = SCALE_DB * (np.log10(PER_HZ * f_hz + OFFSET) / np.log10(OFFSET)) ** 2
    return np.minimum(bowl_db, DEPTH_DB)


WINDOW = (0.35875, 0.48829, 0.14128, 0.01168)
"""Coefficients of the four-term Blackman-Harris window: sidelobes at -92 dB, four lines to either side of a peak."""
FAINT = 1e-9
SHORTEST = 4
STEEP = 0.2
"""Of the power of a peak, what a line beside it has at least; less is where the mean was taken out."""


@dataclass(frozen=True, eq=False)
class Components:
    """The sinusoids in a record: frequencies (Hz) above 0 and their amplitudes, two arrays of one length."""

    frequencies_hz: FloatArray
    amplitudes: FloatArray


def components(samples: ArrayLike, rate_hz: float, padding: int = 1) -> Components:
    """The peaks of the amplitude spectrum of a record (n_samples,), its mean left out.

    The record is padded with zeros to `padding` times its length. Through the highest line of a peak and its neighbours
    goes a parabola in logarithms, which the transform of a Blackman-Harris window nearly is: it reads the amplitude of
    a steady component within 0.37 %, and its frequency within 0.004 lines, wherever it lies between two lines. Of one
    with ramps it reads the mean under the window. Peaks fainter than 1e-9 of the largest sample are rounding.

    >>> t = np.arange(4000) / 4000
    >>> found = components(3 + 0.5 * np.sin(2 * np.pi * 60 * t), 4000.0)
    >>> found.frequencies_hz.round(3).tolist(), found.amplitudes.round(3).tolist()
    ([60.0], [0.5])
    """
    x = np.asarray(samples, dtype=np.float64)
    if x.ndim != 1 or not np.isfinite(x).all():
        raise InvalidParameter(f"components.samples: found shape {x.shape}, expected (n_samples,) finite numbers")
    largest = float(np.abs(x).max(initial=0.0))
    if x.size < SHORTEST or not largest:
        return Components(np.zeros(0), np.zeros(0))
    window = blackman_harris(x.size)
    scaled, weight = x / largest, float(window.sum())
    lines = np.fft.rfft((scaled - window @ scaled / weight) * window, padding * x.size)
    peaks = _peaks(lines.real**2 + lines.imag**2, (FAINT * weight / 2) ** 2)
    return Components(peaks.frequencies_hz * rate_hz / (padding * x.size), peaks.amplitudes * 2 * largest / weight)


def sensation_level_db(parts: Components, reference: float) -> float:
    """Level (dB) of the component furthest above its threshold; ``-inf`` for silence.

    ``max_n 20 log10(a_n/reference) - T(f_n)`` with `sensitivity_db` as T: the component furthest above
    threshold mediates detection. `reference` is the threshold amplitude at 250 Hz, in the unit of
    the amplitudes.

    >>> at_threshold = Components(np.array([250.0]), np.array([2.0]))
    >>> sensation_level_db(at_threshold, reference=2.0)
    0.0
    """
    positive("sensation_level_db", reference=reference)
    audible = parts.amplitudes > 0
    if not audible.any():
        return -np.inf
    levels_db = 20 * np.log10(parts.amplitudes[audible] / reference)
    return float(np.max(levels_db - sensitivity_db(parts.frequencies_hz[audible])))


@lru_cache(maxsize=8)
def blackman_harris(n: int) -> FloatArray:
    """(n,): the window, of a period n, so that sample n would be the first again.

    scipy.signal has it too, and takes longer to load than a scene to compute.

    >>> blackman_harris(4).round(5).tolist()
    [6e-05, 0.21747, 1.0, 0.21747]
    """
    angle = np.linspace(-np.pi, np.pi, n + 1)[:-1]
    window = np.asarray(sum(weight * np.cos(k * angle) for k, weight in enumerate(WINDOW)), dtype=np.float64)
    window.setflags(write=False)
    return window


def _peaks(power: FloatArray, floor: float) -> Components:
    """Places (in lines) and heights of the peaks above a power; of two equal lines the first counts."""
    inner = power[1:-1]
    index = 1 + np.flatnonzero((inner > power[:-2]) & (inner >= power[2:]) & (inner > floor))
    before, at, after = (np.log(np.maximum(power[index + k], STEEP * power[index])) / 2 for k in (-1, 0, 1))
    away = (before - after) / (2 * (before - 2 * at + after))
    return Components(index + away, np.exp(at - (before - after) * away / 4))
