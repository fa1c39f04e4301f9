"""Gains over frequency: bands and amplifiers."""

import math
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from tactometry.arguments.checked import Positive, PositiveWhole, checked
from tactometry.arguments.require import within
from tactometry.errors import InvalidParameter

from ..arrays import ComplexArray, FloatArray, fast_length


@runtime_checkable
class GainCurve(Protocol):
    """A linear element in the frequency domain."""

    def at(self, frequency_hz: FloatArray) -> ComplexArray:
        """Return the complex gain at frequencies of at least 0."""


@checked
def filtered(samples: FloatArray, rate_hz: Positive, gain: GainCurve) -> FloatArray:
    """Return samples (..., n) filtered by a linear element, truncated to n."""
    n = samples.shape[-1]
    n_fft = fast_length(max(2 * n, 1))  # wrap-around falls into padding that is cut off
    frequency_hz = np.asarray(np.fft.rfftfreq(n_fft, 1 / rate_hz), float)
    return np.asarray(np.fft.irfft(np.fft.rfft(samples, n_fft) * gain.at(frequency_hz), n_fft)[..., :n])


@checked
@dataclass(frozen=True)
class Band:
    """A zero-phase band pass from f_min to f_max, with raised-cosine flanks of `flank_hz` inside the band.

    Raises `InvalidParameter` if the band is empty.

    Parameters
    ----------
    f_min_hz, f_max_hz : float
        Limits of the band, 0 <= f_min < f_max.
    flank_hz : float
        Width of each flank, at least 0 and at most the width of the band.
    """

    f_min_hz: float
    f_max_hz: Positive
    flank_hz: float = 0.0

    def __post_init__(self) -> None:
        within("Band", 0, np.inf, f_min_hz=self.f_min_hz, flank_hz=self.flank_hz)
        if not self.f_min_hz < self.f_max_hz:
            raise InvalidParameter(
                f"Band: found {self.f_min_hz} to {self.f_max_hz} Hz, which is empty; expected f_min_hz below f_max_hz"
            )

    @property
    def width_hz(self) -> float:
        return self.f_max_hz - self.f_min_hz

    @property
    def mean_hz(self) -> float:
        return (self.f_max_hz + self.f_min_hz) / 2

    def at(self, frequency_hz: FloatArray) -> ComplexArray:
        rise = _step(frequency_hz - self.f_min_hz, self.flank_hz) if self.f_min_hz > 0 else 1.0
        return np.asarray(rise * _step(self.f_max_hz - frequency_hz, self.flank_hz), complex)


@checked
@dataclass(frozen=True)
class Butterworth:
    """Amplifier with a roll-off: 1 / prod(s - poles), order n, -3 dB at the cut-off."""

    cutoff_hz: Positive
    order: PositiveWhole = 1

    def at(self, frequency_hz: FloatArray) -> ComplexArray:
        s = 1j * np.asarray(frequency_hz) / self.cutoff_hz
        k = np.arange(self.order)
        poles = np.exp(1j * math.pi * (2 * k + self.order + 1) / (2 * self.order))
        return np.asarray(np.prod(-poles / (s[..., None] - poles), axis=-1))


def _step(above_hz: FloatArray, flank_hz: float) -> FloatArray:
    """Return 0 below 0, 1 above the flank and a raised cosine between."""
    if flank_hz == 0:
        return np.asarray(above_hz >= 0, float)
    return np.asarray((1 - np.cos(math.pi * np.clip(above_hz, 0, flank_hz) / flank_hz)) / 2)
