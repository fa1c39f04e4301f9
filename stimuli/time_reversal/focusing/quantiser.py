"""How a waveform becomes what the amplifier can emit, between -1 and +1.

The order is fixed: filter the responses, reverse them, then quantise.
"""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from tactometry.arguments.annotations import Matrix
from tactometry.arguments.checked import checked

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
def normalised(waveform: Matrix, *, per_channel: bool = False) -> FloatArray:
    """Scale a waveform to a peak of 1; zeros stay zeros."""
    peak = np.abs(waveform).max(axis=-1 if per_channel else None, keepdims=True, initial=0.0)
    return np.asarray(waveform / np.where(peak > 0, peak, 1.0))


def one_bit() -> Quantiser:
    """Return the default quantiser, imported only when it is needed."""
    from .one_bit import OneBit

    return OneBit()
