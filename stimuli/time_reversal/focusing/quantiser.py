"""How a waveform becomes what the amplifier can emit, between -1 and +1.

The order is fixed: filter the responses, reverse them, then quantise.
"""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from tactometry.arguments.annotations import Matrix
from tactometry.arguments.checked import checked
from tactometry.arguments.require import positive, within
from tactometry.errors import InvalidParameter, LimitExceeded

from ...arrays import FloatArray


@runtime_checkable
class Quantiser(Protocol):
    """A rule from a waveform to the emitted values."""

    def quantise(self, waveform: Matrix, rate_hz: float) -> FloatArray:
        """(n_channels, n_samples) to values in [-1, 1] of the same shape."""


@checked
@dataclass(frozen=True)
class Analogue:
    """The waveform itself, scaled to a peak of 1: by one gain for all channels, or `per_channel`."""

    per_channel: bool = False

    def quantise(self, waveform: Matrix, rate_hz: float) -> FloatArray:
        del rate_hz
        return normalised(waveform, per_channel=self.per_channel)


@checked
@dataclass(frozen=True)
class OneBit:
    """The sign, with +1 for 0: the largest focus that a peak voltage allows."""

    def quantise(self, waveform: Matrix, rate_hz: float) -> FloatArray:
        del rate_hz
        return np.where(waveform >= 0, 1.0, -1.0)


@checked
@dataclass(frozen=True)
class SigmaDelta:
    """One bit per sample whose quantisation noise is pushed to high frequencies.

    Parameters
    ----------
    order : int
        1 or 2.
    scale : float
        Peak of the modulator's input, above 0; 0.7 keeps the second order stable up to a 20th of
        the rate, and up to 1 the first.

    Raises
    ------
    InvalidParameter
        From the constructor, if the order or scale is not as stated.
    LimitExceeded
        From `quantise`, if the modulator overloads: nothing is emitted.
    """

    order: int = 2
    scale: float = 0.7

    def __post_init__(self) -> None:
        if self.order not in (1, 2):
            raise InvalidParameter(f"SigmaDelta.order: found {self.order}, expected 1 or 2")
        positive("SigmaDelta", scale=self.scale)

    def quantise(self, waveform: Matrix, rate_hz: float) -> FloatArray:
        from .sigma_delta import modulate

        del rate_hz
        stream = modulate(self.scale * normalised(waveform), self.order)
        if stream.overloaded:
            raise LimitExceeded(
                f"SigmaDelta(order={self.order}, scale={self.scale}): found a state of "
                f"{stream.peak_state:.3g}, the limit is {stream.limit:.3g}: the modulator overloads; "
                "lower scale (0.7 bears a sine up to a 20th of the rate), or raise the rate; nothing is emitted"
            )
        return stream.bits.astype(float)


@checked
@dataclass(frozen=True)
class PulseWidth:
    """Pulse-width modulation with natural sampling: the sign of the waveform minus a triangular carrier."""

    carrier_hz: float
    scale: float = 1.0

    def __post_init__(self) -> None:
        positive("PulseWidth", carrier_hz=self.carrier_hz)
        within("PulseWidth", 0.0, 1.0, scale=self.scale)

    def quantise(self, waveform: Matrix, rate_hz: float) -> FloatArray:
        if 4 * self.carrier_hz > rate_hz:
            raise InvalidParameter(
                f"PulseWidth.carrier_hz: found {self.carrier_hz}, expected at most "
                f"a quarter of the rate, {rate_hz / 4} Hz"
            )
        turns = np.arange(waveform.shape[-1]) * (self.carrier_hz / rate_hz) % 1
        carrier = 1 - 4 * np.abs(turns - 0.5)
        return np.where(self.scale * normalised(waveform) >= carrier, 1.0, -1.0)


@checked
def normalised(waveform: Matrix, *, per_channel: bool = False) -> FloatArray:
    """The waveform with a peak of 1; zeros stay zeros."""
    peak = np.abs(waveform).max(axis=-1 if per_channel else None, keepdims=True, initial=0.0)
    return np.asarray(waveform / np.where(peak > 0, peak, 1.0))
