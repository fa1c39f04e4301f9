"""A polygon repeated: what square, triangle, trapezoid and pulse train have in common."""

from typing import Protocol

import numpy as np

from tactometry.arguments import require
from tactometry.errors import InvalidParameter
from tactometry.signal import Signal

from ...arrays import FloatArray
from .corners import Corners
from .level import LevelUnit, peak_voltage_v
from .pieces import Pieces, ramped as ramped_pieces
from .timing import (
    check_nyquist,
    check_pulse,
    check_timing,
    n_samples,
    ramped,
)

MOST_HARMONICS = 2**20


class RepeatedPolygon(Protocol):
    """What a waveform says of itself: its polygon, how often it comes in a second, and how it is played."""

    @property
    def corners(self) -> Corners: ...

    @property
    def frequency_hz(self) -> float: ...

    @property
    def voltage_frequency_hz(self) -> float: ...

    @property
    def duration_s(self) -> float: ...

    @property
    def ramp_s(self) -> float: ...

    @property
    def rate_hz(self) -> float: ...

    @property
    def band_limited(self) -> bool: ...

    @property
    def level_unit(self) -> LevelUnit: ...


class Periodic:
    """Samples, exact pieces and force frequency of a repeated polygon with raised-cosine ramps."""

    @property
    def force_frequency_hz(self: RepeatedPolygon) -> float:
        """Twice that of the voltage if half a period later the voltage is the opposite one."""
        return (2 if self.corners.is_antisymmetric else 1) * self.voltage_frequency_hz

    def at(self: RepeatedPolygon, level: float) -> Signal:
        """(1, n_samples) volt; no sample passes the peak that `level` states."""
        shape = ramped(_shape(self), self.ramp_s, self.rate_hz)
        return Signal((peak_voltage_v(level, self.level_unit) * shape)[None, :], self.rate_hz, "V")

    def pieces(self: RepeatedPolygon, level: float) -> Pieces:
        """The voltage exactly, ramps included (which then need a polygon without slopes)."""
        unit = ramped_pieces(self.corners.pieces(self.voltage_frequency_hz, self.duration_s), self.ramp_s)
        return unit.scaled(peak_voltage_v(level, self.level_unit))


def check_periodic(waveform: RepeatedPolygon) -> None:
    """Refuse a frequency, duration, ramp, rate or unit that cannot be played."""
    owner = type(waveform).__name__
    require.positive(owner, frequency_hz=waveform.frequency_hz)
    require.truth(owner, band_limited=waveform.band_limited)
    require.one_of(f"{owner}.level_unit", waveform.level_unit, ("dB re 1 V", "V"))
    check_timing(owner, waveform.duration_s, waveform.ramp_s, waveform.rate_hz)
    check_nyquist(owner, "frequency_hz", waveform.frequency_hz, waveform.rate_hz)
    n_harmonics = waveform.rate_hz / (2 * waveform.voltage_frequency_hz)
    if waveform.band_limited and n_harmonics > MOST_HARMONICS:
        raise InvalidParameter(
            f"{owner}.band_limited: found {n_harmonics:.6g} harmonics below half of rate_hz, expected at most "
            f"{MOST_HARMONICS}; raise frequency_hz or lower rate_hz"
        )


def check_width(waveform: RepeatedPolygon, name: str, width_s: float) -> None:
    """Refuse a pulse or a pause shorter than a sample, which samples would lengthen or miss."""
    if not waveform.band_limited:
        owner = type(waveform).__name__
        check_pulse(f"{owner}.{name}", width_s, waveform.rate_hz, "lengthen it, raise rate_hz or set band_limited")


def _shape(waveform: RepeatedPolygon) -> FloatArray:
    f_hz = waveform.voltage_frequency_hz
    turned = np.mod(f_hz * np.arange(n_samples(waveform.duration_s, waveform.rate_hz)), waveform.rate_hz)
    phase = turned / waveform.rate_hz
    if not waveform.band_limited:
        return waveform.corners.at(np.round(phase, 12))
    return waveform.corners.band_limited(phase, int(np.ceil(waveform.rate_hz / (2 * f_hz))) - 1)
