"""Detection of a vibration by its component furthest above threshold."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments.require import positive
from tactometry.errors import InvalidParameter

from ..arrays import FloatArray
from .sensitivity import sensitivity_db

FAINT = 1e-9
SHORTEST = 4


@dataclass(frozen=True, eq=False)
class Components:
    """The sinusoids in a record: frequencies (Hz) above 0 and their amplitudes, two arrays of one length."""

    frequencies_hz: FloatArray
    amplitudes: FloatArray


def components(samples: ArrayLike, rate_hz: float) -> Components:
    """The peaks of the amplitude spectrum of a record (n_samples,), its mean left out.

    A flat-top window reads the amplitude of a steady component within 0.2 % wherever it lies between two
    bins, and keeps on and off ramps out. Peaks fainter than 1e-9 of the strongest are rounding.

    >>> t = np.arange(4000) / 4000
    >>> found = components(3 + 0.5 * np.sin(2 * np.pi * 60 * t), 4000.0)
    >>> found.frequencies_hz.tolist(), found.amplitudes.round(3).tolist()
    ([60.0], [0.5])
    """
    x = np.asarray(samples, dtype=np.float64)
    if x.ndim != 1 or not np.isfinite(x).all():
        raise InvalidParameter(f"components.samples: found shape {x.shape}, expected (n_samples,) finite numbers")
    if x.size < SHORTEST or not x.any():
        return Components(np.zeros(0), np.zeros(0))
    window = _window(x.size)
    weight = window.sum()
    lines = np.fft.rfft((x - window @ x / weight) * window)
    spectrum = np.asarray(2 * np.abs(lines) / weight, dtype=np.float64)
    return _peaks(spectrum, rate_hz / x.size, FAINT * max(float(spectrum.max()), float(np.abs(x).max())))


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
def _window(n: int) -> FloatArray:
    from scipy.signal.windows import flattop  # half of the start of a session, if it stood above

    window = np.asarray(flattop(n, sym=False))
    window.setflags(write=False)
    return window


def _peaks(spectrum: FloatArray, bin_hz: float, floor: float) -> Components:
    inner = spectrum[1:-1]
    is_peak = (inner > spectrum[:-2]) & (inner >= spectrum[2:]) & (inner > floor)
    index = 1 + np.flatnonzero(is_peak)
    return Components(np.asarray(index * bin_hz, dtype=np.float64), spectrum[index])
