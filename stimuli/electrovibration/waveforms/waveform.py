"""Levels, samples and ramps that all waveforms share."""

from math import log10
from typing import Literal, Protocol, get_args, runtime_checkable

import numpy as np

from tactometry.arguments import require
from tactometry.arguments.constraints import DOMAINS
from tactometry.signal import Signal

from ...arrays import FloatArray
from .pieces import MOST_SAMPLES, Pieces

LevelUnit = Literal["dB re 1 V", "V"]
HIGHEST_V = DOMAINS["_v"][1]


@runtime_checkable
class Waveform(Protocol):
    """Interface of a waveform: levels, samples, ramps and frequencies."""

    @property
    def duration_s(self) -> float: ...

    @property
    def ramp_s(self) -> float: ...

    @property
    def level_unit(self) -> LevelUnit: ...

    @property
    def voltage_frequency_hz(self) -> float: ...

    @property
    def force_frequency_hz(self) -> float: ...

    def at(self, level: float) -> Signal: ...

    def pieces(self, level: float) -> Pieces: ...


class Ramped(Waveform):
    """Base class of most waveforms: a shape with raised-cosine ramps, scaled to a level.

    Parameters
    ----------
    duration_s : float
        Whole length, ramps included.
    ramp_s : float
        Length of the raised-cosine ramps at onset and offset; the default of 50 ms is a choice.
    rate_hz : float
        Samples per second; the default of 20 kHz leaves room for the doubled bandwidth of the force.
    level_unit : {"dB re 1 V", "V"}
        Unit of the level: decibel re 1 V peak, or volt peak.
    """

    rate_hz: float

    def __post_init__(self) -> None:
        owner = type(self).__name__
        require.one_of(f"{owner}.level_unit", self.level_unit, get_args(LevelUnit))
        check_timing(owner, self.duration_s, self.ramp_s, self.rate_hz)

    def at(self, level: float) -> Signal:
        """Return samples (1, n_samples) in volt, at most the peak of `level`."""
        samples = peak_voltage_v(level, self.level_unit) * ramped(self._unit(), self.ramp_s, self.rate_hz)
        return Signal(samples[None, :], self.rate_hz, "V")

    def _unit(self) -> FloatArray:
        """Return samples (n_samples,) of peak 1, without ramps."""
        raise NotImplementedError


def peak_voltage_v(level: float, unit: LevelUnit = "dB re 1 V") -> float:
    """Return the peak voltage (V), ``10**(level/20)`` for a level in dB.

    Raises `InvalidParameter` if the level is not finite or above `HIGHEST_V`, or a level in volt is negative.

    >>> peak_voltage_v(20.0)
    10.0
    >>> peak_voltage_v(0.0, "V")
    0.0
    """
    require.one_of("level_unit", unit, get_args(LevelUnit))
    require.finite("stimulus", level=level)
    if unit == "V":
        require.not_negative("stimulus", level=level)
        require.expect(level <= HIGHEST_V, "stimulus.level", f"{level} V", f"at most {HIGHEST_V:g} V")
        return float(level)
    highest_db = 20 * log10(HIGHEST_V)
    require.expect(level <= highest_db, "stimulus.level", f"{level} dB re 1 V", f"at most {highest_db:g} dB")
    return float(10 ** (level / 20))


def level_db_re_1v(voltage_v: float) -> float:
    """Return the level (dB re 1 V) of a peak voltage above 0.

    >>> round(level_db_re_1v(200.0), 2)
    46.02
    """
    require.positive("level_db_re_1v", voltage_v=voltage_v)
    return 20 * log10(voltage_v)


def n_samples(duration_s: float, rate_hz: float) -> int:
    return round(duration_s * rate_hz)


def check_timing(owner: str, duration_s: float, ramp_s: float, rate_hz: float) -> None:
    """Check the number of samples and the length of the ramps.

    >>> check_timing("Sine", duration_s=0.1, ramp_s=0.06, rate_hz=20e3)
    Traceback (most recent call last):
    tactometry.errors.InvalidParameter: Sine.ramp_s: found 0.06 s on and off, \
expected at most half of the duration of 0.1 s; shorten the ramp
    """
    require.positive(owner, duration_s=duration_s, rate_hz=rate_hz)
    require.not_negative(owner, ramp_s=ramp_s)
    most = f"at most {MOST_SAMPLES} samples at {rate_hz} Hz; shorten the signal or lower rate_hz"
    require.expect(duration_s * rate_hz <= MOST_SAMPLES, f"{owner}.duration_s", f"{duration_s} s", most)
    least = f"at least one sample at {rate_hz} Hz"
    require.expect(n_samples(duration_s, rate_hz) >= 1, f"{owner}.duration_s", f"{duration_s} s", least)
    half = f"at most half of the duration of {duration_s} s; shorten the ramp"
    require.expect(2 * ramp_s <= duration_s * (1 + 1e-12), f"{owner}.ramp_s", f"{ramp_s} s on and off", half)


def check_nyquist(owner: str, name: str, frequency_hz: float, rate_hz: float) -> None:
    """Raise an error if a frequency is not below half of the rate."""
    below = f"less than half of rate_hz ({rate_hz / 2} Hz); lower the frequency or raise rate_hz"
    require.expect(frequency_hz < rate_hz / 2, f"{owner}.{name}", f"{frequency_hz} Hz", below)


def check_pulse(where: str, width_s: float, rate_hz: float, mending: str) -> None:
    """Raise an error if a pulse is so short that samples may miss it."""
    expected = f"at least one sample ({1 / rate_hz:.6g} s); {mending}"
    require.expect(width_s >= 1 / rate_hz * (1 - 1e-9), where, f"a pulse of {width_s:.6g} s", expected)


def times_s(duration_s: float, rate_hz: float) -> FloatArray:
    """Return the times (n_samples,) of the samples, from 0."""
    return np.arange(n_samples(duration_s, rate_hz)) / rate_hz


def ramped(shape: FloatArray, ramp_s: float, rate_hz: float) -> FloatArray:
    """Return `shape` (n_samples,) with raised-cosine onset and offset ramps.

    >>> ramped(np.ones(6), 2.0, 1.0).round(3).tolist()
    [0.0, 0.5, 1.0, 1.0, 0.5, 0.0]
    """
    n = shape.shape[-1]
    n_ramp = min(n_samples(ramp_s, rate_hz), n // 2)
    rise = (1 - np.cos(np.pi * np.arange(n_ramp) / max(n_ramp, 1))) / 2
    envelope = np.ones(n)
    envelope[:n_ramp] = rise
    envelope[n - n_ramp :] *= rise[::-1]
    return shape * envelope
