"""Receptor channels of the skin: each has its own threshold by frequency, and the strongest mediates detection."""

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments.require import positive, positive_array

from ..arrays import FloatArray
from .detection import Components

NP_III, NP_I, P = 0, 1, 2
"""Rows: Merkel, Meissner, Pacini. NP II, of very small contactors alone, is left out."""
BEST_DB = -20.0


def channel_thresholds_db(frequency_hz: ArrayLike) -> FloatArray:
    """(3, n): threshold of NP III, NP I and P (dB re the best one, of P at 250 Hz); infinite where a channel is deaf.

    A piecewise form of the model of Bolanowski, Gescheider, Verrillo and Checkosky (J. Acoust. Soc. Am. 84, 1680,
    1988) for a contactor of 2.9 cm^2; its numbers are unverified defaults.

    Raises
    ------
    InvalidParameter
        If a frequency is not a finite number above 0.

    >>> channel_thresholds_db([1.0, 40.0, 250.0]).min(axis=0).round(1).tolist()
    [48.0, 29.3, 0.0]
    """
    f_hz = np.atleast_1d(positive_array("frequency_hz", frequency_hz))
    curves = np.stack(
        [np.full(f_hz.shape, 28.0), 28 - 5 * np.log2(f_hz / 3), BEST_DB + 12 * np.abs(np.log2(250 / f_hz))]
    )
    hears = np.stack([(f_hz >= low) & (f_hz <= high) for low, high in ((0.4, 3.0), (3.0, 100.0), (35.0, 800.0))])
    return np.where(hears, curves - BEST_DB, np.inf)


def channel_levels_db(parts: Components, reference: float) -> FloatArray:
    """(3,): level of each channel by its component furthest above threshold; ``-inf`` where nothing is felt.

    `reference` is the amplitude at threshold at 250 Hz, in the unit of the components.

    >>> channel_levels_db(Components(np.array([250.0]), np.array([2.0])), reference=2.0).tolist()
    [-inf, -inf, 0.0]
    """
    positive("channel_levels_db", reference=reference)
    heard = parts.amplitudes > 0
    levels_db = 20 * np.log10(parts.amplitudes[heard] / reference) - channel_thresholds_db(parts.frequencies_hz[heard])
    return np.asarray(levels_db.max(axis=1, initial=-np.inf))


def summation_db(area_m2: float, reference_m2: float) -> float:
    """What P gains by a larger contact: 3 dB per doubling of the area (Craig and Sherrick 1969).

    >>> round(summation_db(2e-4, 1e-4), 2)
    3.01
    """
    positive("summation_db", area_m2=area_m2, reference_m2=reference_m2)
    return float(10 * np.log10(area_m2 / reference_m2))
