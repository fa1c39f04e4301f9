"""Impulse responses through a gain: the band, the audible part, the amplifier."""

from dataclasses import replace

import numpy as np

from tactometry.arguments.checked import checked
from tactometry.errors import InvalidParameter

from ..filters import AUDIBLE_MAX_HZ, Band, GainCurve
from .responses import Responses


@checked
def through(responses: Responses, gain: GainCurve) -> Responses:
    """The responses behind a linear element; the part that would precede time 0 is cut off.

    Examples
    --------
    >>> h = Responses(np.eye(1, 64)[None], 1e3)
    >>> from tactometry.stimuli.time_reversal.filters import Butterworth
    >>> np.round(through(h, Butterworth(10.0)).samples[0, 0, :2], 3)
    array([0.031, 0.065])
    """
    n = responses.n_samples
    n_fft = _fast_length(2 * n)  # what rings beyond the end, or before time 0, wraps into zeros that are cut off
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


def _fast_length(n: int) -> int:
    from scipy.fft import next_fast_len

    return int(next_fast_len(max(n, 1), real=True))
