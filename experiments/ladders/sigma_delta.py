"""A tone as one bit per sample: what is left of it in the band, against the rate of the bits."""

from functools import partial

import numpy as np
from numpy.typing import NDArray

from tactometry.stimuli.time_reversal.focusing.modulator import modulate

from ..cost.problem import Problem, Real, Reference, Rung, over_rms

TONE_HZ, BAND_HZ, DURATION_S, AMPLITUDE = 5e3, 25e3, 20e-3, 0.5
RATES_HZ = (250e3, 1e6, 4e6, 16e6)
Complex = NDArray[np.complex128]


def first_order() -> Problem:
    return _problem(1)


def second_order() -> Problem:
    return _problem(2)


def _problem(order: int) -> Problem:
    return Problem(
        f"rms error in the band of 0 to 25 kHz over the rms of a 5 kHz tone, order {order}, 20 ms",
        reference=Reference("the line of the tone", _line, 1e-12),
        independent=Reference("transform of the tone", lambda: _spectrum(_tone(RATES_HZ[0])), 1e-12),
        error=over_rms,
        rungs=tuple(Rung(f"{rate_hz / 1e6:g} MHz", partial(_modulation, order, rate_hz)) for rate_hz in RATES_HZ),
    )


def _tone(rate_hz: float) -> Real:
    times_s = np.arange(round(DURATION_S * rate_hz)) / rate_hz
    return AMPLITUDE * np.sin(2 * np.pi * TONE_HZ * times_s)


def _modulation(order: int, rate_hz: float) -> Complex:
    return _spectrum(modulate(_tone(rate_hz)[None, :], order).bits[0])


def _spectrum(samples: NDArray[np.generic]) -> Complex:
    """Amplitudes of the lines in the band."""
    return np.asarray(2 * np.fft.rfft(samples)[: round(BAND_HZ * DURATION_S) + 1] / samples.size)


def _line() -> Complex:
    lines = np.zeros(round(BAND_HZ * DURATION_S) + 1, complex)
    lines[round(TONE_HZ * DURATION_S)] = -1j * AMPLITUDE
    return lines
