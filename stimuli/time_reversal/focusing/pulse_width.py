"""Pulse-width modulation of the reversed responses."""

from dataclasses import dataclass

import numpy as np

from tactometry.arguments.checked import Matrix, Positive, checked
from tactometry.arguments.require import expect, within

from ...arrays import FloatArray
from ...composition.effect import Demand, Quantity, Size


@checked
@dataclass(frozen=True)
class PulseWidth(Quantity):
    """Pulse-width modulation with natural sampling: the sign of the waveform minus a triangular carrier.

    Parameters
    ----------
    carrier_hz : float
        Frequency of the triangle that the waveform is compared with.
    scale : float
        Peak of the waveform divided by that of the triangle, above 0, at most 1.
    """

    kind, slot, gives = "pulse_width", "quantiser", "quantiser"
    in_signal = True

    carrier_hz: Positive
    scale: Positive = 1.0

    def __post_init__(self) -> None:
        within("PulseWidth", 0.0, 1.0, scale=self.scale)

    def quantise(self, waveform: Matrix, rate_hz: float) -> FloatArray:
        from .quantiser import normalised

        self._check_rate(rate_hz)
        turns = np.arange(waveform.shape[-1]) * (self.carrier_hz / rate_hz) % 1
        carrier = 1 - 4 * np.abs(turns - 0.5)
        return np.where(self.scale * normalised(waveform) >= carrier, 1.0, -1.0)

    def size(self, demand: Demand) -> Size:
        """Raise an error if the clock of the surface is too slow."""
        self._check_rate(demand.surface.rate_hz)
        return Size()

    def _check_rate(self, rate_hz: float) -> None:
        expected = f"at most a quarter of the rate, {rate_hz / 4} Hz; lower it or raise rate_hz"
        expect(4 * self.carrier_hz <= rate_hz, "PulseWidth.carrier_hz", self.carrier_hz, expected)
