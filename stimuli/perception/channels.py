"""Thresholds of the skin's receptor channels."""

from functools import lru_cache
from math import inf, log10
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments.require import positive, positive_array

from ..arrays import FloatArray, IntArray
from ..defaults import BEST_DB, THRESHOLD_M
from .detection import Components

NP_III, NP_I, P = 0, 1, 2
"""Rows: Merkel, Meissner, Pacini. NP II, which matters for very small contactors only, is omitted."""
HEARS_HZ: Final = ((0.4, 3.0), (3.0, 100.0), (35.0, 800.0))
"""Frequency range in which each channel responds."""
NP_III_DB: Final = 28.0
NP_I_DB: Final = 28.0
"""Thresholds of NP III, and of NP I at 3 Hz, dB re 1 um."""
NP_I_DB_PER_OCTAVE: Final = 5.0
P_DB_PER_OCTAVE: Final = 12.0
"""Slopes of the thresholds: falling of NP I, and of P on both sides of `BEST_HZ`."""
BEST_HZ: Final = 250.0


def channel_thresholds_db(frequency_hz: ArrayLike) -> FloatArray:
    """Return thresholds (3, n) of NP III, NP I and P, in dB re the lowest.

    A piecewise form of the model of Bolanowski, Gescheider, Verrillo and Checkosky (J. Acoust. Soc. Am. 84, 1680,
    1988) for a contactor of 2.9 cm^2. `stimuli/sources.toml` states the source and range of each number.

    Raises `InvalidParameter` if a frequency is not a finite number above 0.

    >>> channel_thresholds_db([1.0, 40.0, 250.0]).min(axis=0).round(1).tolist()
    [48.0, 29.3, 0.0]
    """
    f_hz = np.atleast_1d(positive_array("frequency_hz", frequency_hz))
    np_i = NP_I_DB - NP_I_DB_PER_OCTAVE * np.log2(f_hz / 3)
    p = BEST_DB + P_DB_PER_OCTAVE * np.abs(np.log2(BEST_HZ / f_hz))
    curves = np.stack([np.full(f_hz.shape, NP_III_DB), np_i, p])
    hears = np.stack([(f_hz >= low) & (f_hz <= high) for low, high in HEARS_HZ])
    return np.where(hears, curves - BEST_DB, np.inf)


def channel_levels_db(skin: Components, reference_m: float = THRESHOLD_M) -> FloatArray:
    """Return the level (3,) of each channel; ``-inf`` if not felt.

    `skin` contains displacements (m); `reference_m` is the displacement at threshold at 250 Hz.

    >>> channel_levels_db(Components(np.array([250.0]), np.array([1e-6]))).round(9).tolist()
    [-inf, -inf, 20.0]
    """
    positive("channel_levels_db", reference_m=reference_m)
    felt = skin.amplitudes > 0
    levels_db = 20 * np.log10(skin.amplitudes[felt] / reference_m) - channel_thresholds_db(skin.frequencies_hz[felt])
    return np.asarray(levels_db.max(axis=1, initial=-np.inf))


def sensation_level_db(skin: Components, reference_m: float = THRESHOLD_M) -> float:
    """Return the level (dB) above the lowest threshold, or ``-inf``.

    It is the highest of `channel_levels_db`: the most sensitive channel mediates detection.

    >>> round(sensation_level_db(Components(np.array([40.0]), np.array([1e-6]))), 2)
    -9.32
    """
    positive("sensation_level_db", reference_m=reference_m)
    return highest_level_db(as_at_250_hz(skin), reference_m)


def as_at_250_hz(parts: Components) -> Components:
    """Scale components to equally perceptible components at 250 Hz.

    >>> as_at_250_hz(Components(np.array([0.1, 125.0, 900.0]), np.ones(3))).amplitudes.round(4).tolist()
    [0.2512]
    """
    within, f_hz, weights = _weights(np.asarray(parts.frequencies_hz, np.float64).tobytes())
    return Components(f_hz, parts.amplitudes[within] * weights)


def heard(parts: Components) -> Components:
    """Return the components to which any channel responds.

    >>> heard(Components(np.array([0.1, 125.0, 900.0]), np.ones(3))).frequencies_hz
    array([125.])
    """
    within = _within(parts.frequencies_hz)
    return Components(parts.frequencies_hz[within], parts.amplitudes[within])


def _within(frequencies_hz: FloatArray) -> IntArray:
    return np.flatnonzero((frequencies_hz >= HEARS_HZ[NP_III][0]) & (frequencies_hz <= HEARS_HZ[P][1]))


@lru_cache(maxsize=64)
def _weights(lines_hz: bytes) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return indices, frequencies and sensitivities of perceptible lines."""
    frequencies_hz = np.frombuffer(lines_hz)
    within = _within(frequencies_hz)
    f_hz = frequencies_hz[within]
    return within, f_hz, np.asarray(10 ** (-channel_thresholds_db(f_hz).min(axis=0) / 20))


def highest_level_db(weighed: Components, reference_m: float) -> float:
    """Return the level (dB) of the largest of amplitudes at 250 Hz."""
    largest_m = float(weighed.amplitudes.max(initial=0.0))
    return 20 * log10(largest_m / reference_m) if largest_m > 0 else -inf


def summation_db(area_m2: float, reference_m2: float) -> float:
    """Return P's sensitivity gain (dB) from contact area: 3 dB per doubling.

    After Craig and Sherrick (1969).

    >>> round(summation_db(2e-4, 1e-4), 2)
    3.01
    """
    positive("summation_db", area_m2=area_m2, reference_m2=reference_m2)
    return float(10 * np.log10(area_m2 / reference_m2))
