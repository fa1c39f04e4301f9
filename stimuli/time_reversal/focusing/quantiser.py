"""Quantisers from a waveform to values that an amplifier can emit.

The order is fixed: filter the responses, reverse them, then quantise.
"""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from tactometry.arguments.checked import Matrix, checked

from ...arrays import FloatArray


@runtime_checkable
class Quantiser(Protocol):
    """Interface of a quantiser: a rule from a waveform to emitted values."""

    def quantise(self, waveform: Matrix, rate_hz: float) -> FloatArray:
        """Map a waveform (n_channels, n_samples) to values in [-1, 1]."""


@checked
@dataclass(frozen=True)
class Analogue:
    """Analogue drive: the waveform scaled to a peak of 1, by one common gain or `per_channel`."""

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
