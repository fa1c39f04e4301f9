"""What the polygonal waveforms have in common."""

import numpy as np

from tactometry.signal import Signal
from tactometry.stimuli.electrovibration import require
from tactometry.stimuli.electrovibration.corners import Corners
from tactometry.stimuli.electrovibration.level import LevelUnit, peak_voltage_v
from tactometry.stimuli.electrovibration.pieces import Pieces
from tactometry.stimuli.electrovibration.pieces import ramped as ramped_pieces
from tactometry.stimuli.electrovibration.timing import check_nyquist, check_timing, ramped, times_s


def check_periodic(
    owner: str, frequency_hz: float, *, duration_s: float, ramp_s: float, rate_hz: float, level_unit: str
) -> None:
    """Refuse a frequency, duration, ramp, rate or unit that cannot be played."""
    require.positive(owner, frequency_hz=frequency_hz)
    require.one_of(f"{owner}.level_unit", level_unit, ("dB re 1 V", "V"))
    check_timing(owner, duration_s, ramp_s, rate_hz)
    check_nyquist(owner, "frequency_hz", frequency_hz, rate_hz)


def periodic_signal(
    corners: Corners,
    frequency_hz: float,
    *,
    peak_v: float,
    duration_s: float,
    ramp_s: float,
    rate_hz: float,
    band_limited: bool,
) -> Signal:
    """(1, n_samples) volt of a repeated polygon with ramps."""
    phase = frequency_hz * times_s(duration_s, rate_hz)
    n_highest = int(np.ceil(rate_hz / (2 * frequency_hz))) - 1
    shape = corners.band_limited(phase, n_highest) if band_limited else corners.at(np.round(phase, 12))
    return Signal((peak_v * ramped(shape, ramp_s, rate_hz))[None, :], rate_hz, "V")


def periodic_pieces(
    corners: Corners, frequency_hz: float, *, duration_s: float, ramp_s: float, level: float, unit: LevelUnit
) -> Pieces:
    """The repeated polygon exactly, ramps included (which then need a polygon without slopes)."""
    unit_v = ramped_pieces(corners.pieces(frequency_hz, duration_s), ramp_s)
    return unit_v.scaled(peak_voltage_v(level, unit))
