"""One-bit drives: the sign of the reversed responses."""

from dataclasses import dataclass

import numpy as np

from tactometry.arguments.checked import Matrix, checked

from ...arrays import FloatArray
from ...composition.effect import Quantity


@checked
@dataclass(frozen=True)
class OneBit(Quantity):
    """One-bit quantiser (sign, with +1 for 0): gives the largest focus amplitude for a given peak voltage."""

    kind, slot, gives = "one_bit", "quantiser", "quantiser"
    in_signal = True

    def quantise(self, waveform: Matrix, rate_hz: float) -> FloatArray:
        del rate_hz
        return np.where(waveform >= 0, 1.0, -1.0)
