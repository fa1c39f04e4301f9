"""Sample times and on and off ramps."""

import numpy as np

from tactometry.arguments import require
from tactometry.errors import InvalidParameter

from ...arrays import FloatArray

MOST_SAMPLES = 2**28


def n_samples(duration_s: float, rate_hz: float) -> int:
    """The number of samples of a signal, to the nearest one."""
    return round(duration_s * rate_hz)


def check_timing(owner: str, duration_s: float, ramp_s: float, rate_hz: float) -> None:
    """Refuse a signal without samples, with more than `MOST_SAMPLES`, or with ramps longer than itself.

    >>> check_timing("Sine", duration_s=0.1, ramp_s=0.06, rate_hz=20e3)
    Traceback (most recent call last):
    tactometry.errors.InvalidParameter: Sine.ramp_s: found 0.06 s on and off, \
expected at most half of the duration of 0.1 s; shorten the ramp
    """
    require.positive(owner, duration_s=duration_s, rate_hz=rate_hz)
    require.not_negative(owner, ramp_s=ramp_s)
    if duration_s * rate_hz > MOST_SAMPLES:
        raise InvalidParameter(
            f"{owner}.duration_s: found {duration_s} s, expected at most {MOST_SAMPLES} samples at {rate_hz} Hz; "
            "shorten the signal or lower rate_hz"
        )
    if n_samples(duration_s, rate_hz) < 1:
        raise InvalidParameter(
            f"{owner}.duration_s: found {duration_s} s, expected at least one sample at {rate_hz} Hz"
        )
    if 2 * ramp_s > duration_s * (1 + 1e-12):
        raise InvalidParameter(
            f"{owner}.ramp_s: found {ramp_s} s on and off, expected at most half of the duration of "
            f"{duration_s} s; shorten the ramp"
        )


def check_nyquist(owner: str, name: str, frequency_hz: float, rate_hz: float) -> None:
    """Refuse a frequency at or above half of the rate: its samples would be those of another one."""
    if frequency_hz >= rate_hz / 2:
        raise InvalidParameter(
            f"{owner}.{name}: found {frequency_hz} Hz, expected less than half of rate_hz "
            f"({rate_hz / 2} Hz); lower the frequency or raise rate_hz"
        )


def check_pulse(where: str, width_s: float, rate_hz: float, mending: str) -> None:
    """Refuse a pulse shorter than a sample: it may fall between two of them."""
    if width_s < 1 / rate_hz * (1 - 1e-9):
        raise InvalidParameter(
            f"{where}: found a pulse of {width_s:.6g} s, expected at least one sample ({1 / rate_hz:.6g} s); {mending}"
        )


def times_s(duration_s: float, rate_hz: float) -> FloatArray:
    """(n_samples,) times of the samples from 0."""
    return np.arange(n_samples(duration_s, rate_hz)) / rate_hz


def raised_cosine(n: int, n_ramp: int) -> FloatArray:
    """(n,) envelope that rises from 0 over `n_ramp` samples, holds 1, and falls to 0 in the mirror image.

    >>> raised_cosine(6, 2).round(3).tolist()
    [0.0, 0.5, 1.0, 1.0, 0.5, 0.0]
    """
    envelope = np.ones(n)
    rise = (1 - np.cos(np.pi * np.arange(n_ramp) / max(n_ramp, 1))) / 2
    envelope[:n_ramp] = rise
    envelope[n - n_ramp :] *= rise[::-1]
    return envelope


def ramped(shape: FloatArray, ramp_s: float, rate_hz: float) -> FloatArray:
    """`shape` (n_samples,) with raised-cosine ramps on and off."""
    n = shape.shape[-1]
    return shape * raised_cosine(n, min(n_samples(ramp_s, rate_hz), n // 2))
