"""How the threshold of touch depends on frequency."""

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments.require import not_negative_array

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
