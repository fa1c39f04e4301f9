"""Filters on impulse responses: the band, the audible part, the amplifier."""

import math
from dataclasses import dataclass, replace
from typing import Final, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from tactometry.arguments.checked import checked
from tactometry.arguments.require import positive, within
from tactometry.errors import InvalidParameter

from .responses import Responses

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

AUDIBLE_MAX_HZ: Final = 20e3
"""Where the audible-band filter begins to pass; unverified default."""


@runtime_checkable
class GainCurve(Protocol):
    """A linear element in the frequency domain."""

    def at(self, frequency_hz: FloatArray) -> ComplexArray:
        """Complex gain at frequencies of at least 0."""


@checked
@dataclass(frozen=True)
class Band:
    """Passes f_min..f_max without a change of phase; raised-cosine flanks of `flank_hz` lie inside the band.

    Parameters
    ----------
    f_min_hz, f_max_hz : float
        0 <= f_min < f_max.
    flank_hz : float
        At least 0; at most the width of the band.

    Raises
    ------
    InvalidParameter
        If the band is empty.
    """

    f_min_hz: float
    f_max_hz: float
    flank_hz: float = 0.0

    def __post_init__(self) -> None:
        positive("Band", f_max_hz=self.f_max_hz)
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
    """Amplifier that rolls off: 1 / prod(s - poles), order n, -3 dB at the cut-off."""

    cutoff_hz: float
    order: int = 1

    def __post_init__(self) -> None:
        positive("Butterworth", cutoff_hz=self.cutoff_hz, order=self.order)

    def at(self, frequency_hz: FloatArray) -> ComplexArray:
        s = 1j * np.asarray(frequency_hz) / self.cutoff_hz
        k = np.arange(self.order)
        poles = np.exp(1j * math.pi * (2 * k + self.order + 1) / (2 * self.order))
        return np.asarray(np.prod(-poles / (s[..., None] - poles), axis=-1))


@checked
@dataclass(frozen=True)
class MeasuredGain:
    """An amplifier's measured gain, linear between its frequencies and constant outside.

    Parameters
    ----------
    frequency_hz : tuple of float
        Ascending.
    gain : tuple of complex
        As many.
    """

    frequency_hz: tuple[float, ...]
    gain: tuple[complex, ...]

    def __post_init__(self) -> None:
        if len(self.frequency_hz) != len(self.gain) or not self.gain:
            raise InvalidParameter(
                f"MeasuredGain: found {len(self.frequency_hz)} frequencies and {len(self.gain)} gains, expected as many"
            )
        if any(b <= a for a, b in zip(self.frequency_hz, self.frequency_hz[1:], strict=False)):
            raise InvalidParameter("MeasuredGain.frequency_hz: found values that do not rise, expected ascending ones")

    def at(self, frequency_hz: FloatArray) -> ComplexArray:
        return np.asarray(np.interp(frequency_hz, self.frequency_hz, np.asarray(self.gain, complex)))


@checked
@dataclass(frozen=True)
class Hold:
    """An output that holds each sample: sinc(f / rate) and half a sample of delay."""

    rate_hz: float

    def at(self, frequency_hz: FloatArray) -> ComplexArray:
        relative = np.asarray(frequency_hz) / self.rate_hz
        return np.asarray(np.sinc(relative) * np.exp(-1j * math.pi * relative))


@checked
def through(responses: Responses, gain: GainCurve) -> Responses:
    """The responses behind a linear element; the part that would precede time 0 is cut off.

    Examples
    --------
    >>> h = Responses(np.eye(1, 64)[None], 1e3)
    >>> np.round(through(h, Butterworth(10.0)).samples[0, 0, :2], 3)
    array([0.031, 0.065])
    """
    n = responses.n_samples
    n_fft = _fast_length(2 * n)
    frequency_hz = np.fft.rfftfreq(n_fft, 1 / responses.rate_hz)
    spectrum = np.fft.rfft(responses.samples, n_fft) * gain.at(np.asarray(frequency_hz, float))
    return replace(responses, samples=np.fft.irfft(spectrum, n_fft)[..., :n])


@checked
def band_limited(responses: Responses, band: Band) -> Responses:
    """The responses within a band.

    Raises
    ------
    InvalidParameter
        If the band reaches above the Nyquist frequency.
    """
    if 2 * band.f_max_hz > responses.rate_hz * (1 + 1e-12):
        raise InvalidParameter(
            f"Band.f_max_hz: found {band.f_max_hz}, above the Nyquist frequency "
            f"{responses.rate_hz / 2} of the responses; lower it"
        )
    return through(responses, band)


@checked
def inaudible(responses: Responses, cutoff_hz: float = AUDIBLE_MAX_HZ, flank_hz: float = 0.0) -> Responses:
    """The audible-band filter: only what lies above `cutoff_hz`. Filter first, then reverse, then
    quantise.
    """
    return band_limited(responses, Band(cutoff_hz, responses.rate_hz / 2, flank_hz))


def _step(above_hz: FloatArray, flank_hz: float) -> FloatArray:
    """0 below 0, 1 above the flank, a raised cosine between."""
    if flank_hz == 0:
        return np.asarray(above_hz >= 0, float)
    return np.asarray((1 - np.cos(math.pi * np.clip(above_hz, 0, flank_hz) / flank_hz)) / 2)


def _fast_length(n: int) -> int:
    from scipy.fft import next_fast_len

    return int(next_fast_len(max(n, 1), real=True))
