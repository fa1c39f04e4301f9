"""Figures of merit of a focus, each with its definition in the name.

Amplitude is the displacement at the focus. Contrasts are ratios of that amplitude to an rms, not in decibels.
"""

import math

import numpy as np

from tactometry.arguments.annotations import Matrix, Vector
from tactometry.arguments.checked import checked
from tactometry.arguments.require import ascending, between, not_negative, positive, whole, within
from tactometry.errors import InvalidParameter

from ...arrays import FloatArray

Grid = tuple[Vector, Vector]

HALF: float = 0.5
"""-6 dB of amplitude."""


@checked
def contrast_whole_of(amplitude_m: float, field_m: FloatArray) -> float:
    """|A| over the rms of the field on the whole plate at the focus instant."""
    return _ratio(amplitude_m, field_m)


@checked
def contrast_far_of(
    amplitude_m: float, field_m: Matrix, grid_m: Grid, focus_m: tuple[float, float], radius_m: float
) -> float:
    """As `contrast_whole_of`, without the points nearer than `radius_m` to the focus."""
    not_negative("contrast_far_of", radius_m=radius_m)
    away = np.hypot(grid_m[0][:, None] - focus_m[0], grid_m[1][None, :] - focus_m[1]) >= radius_m
    return _ratio(amplitude_m, field_m[away])


@checked
def contrast_temporal_of(signal_m: Vector, focus_sample: int, rate_hz: float, start_s: float, stop_s: float) -> float:
    """|A| over the rms at the focus point from `start_s` to `stop_s` after the focus."""
    positive("contrast_temporal_of", rate_hz=rate_hz)
    within("contrast_temporal_of", 0, len(signal_m) - 1, focus_sample=focus_sample)
    first, last = (focus_sample + round(t * rate_hz) for t in (start_s, stop_s))
    if not 0 <= first < last <= len(signal_m):
        raise InvalidParameter(
            f"start_s, stop_s: found {start_s} and {stop_s}, expected a window inside of the signal of "
            f"{len(signal_m) / rate_hz} s"
        )
    return _ratio(float(signal_m[focus_sample]), signal_m[first:last])


@checked
def width_m(at_m: Vector, profile: Vector, level: float = HALF) -> float:
    """Full width of a focus along a line, between the crossings of `level` nearest to the peak.

    `HALF` gives the width at -6 dB, 0.7071 at -3 dB; crossings are found by linear interpolation.

    >>> x = np.linspace(-1.0, 1.0, 201)
    >>> round(width_m(x, 1 - np.abs(x)), 12)
    1.0
    """
    ascending("width_m.at_m", at_m)
    between("width_m", 0, 1, level=level)
    if np.shape(profile) != np.shape(at_m) or not np.any(profile):
        raise InvalidParameter(
            f"profile: found shape {np.shape(profile)}, expected {np.shape(at_m)} as at_m has, not all zero"
        )
    peak = int(np.argmax(np.abs(profile)))
    relative = profile / profile[peak]  # 1 at the peak, whichever its sign
    right = _crossing(at_m[peak:], relative[peak:], level)
    left = _crossing(at_m[peak::-1], relative[peak::-1], level)
    return right - left


@checked
def area_m2(field_m: Matrix, grid_m: Grid, level: float = HALF) -> float:
    """Area around the peak that stays above `level` times the peak, counting cells connected to the peak."""
    from scipy.ndimage import label

    between("area_m2", 0, 1, level=level)
    for axis_m in grid_m:
        ascending("area_m2.grid_m", axis_m)
    if field_m.shape != tuple(map(len, grid_m)) or not field_m.any():
        raise InvalidParameter(
            f"field_m: found shape {field_m.shape}, expected {tuple(map(len, grid_m))} as the grid has, not all zero"
        )
    peak = np.unravel_index(np.argmax(np.abs(field_m)), field_m.shape)
    islands, _ = label(field_m / field_m[peak] >= level)
    cell = (grid_m[0][1] - grid_m[0][0]) * (grid_m[1][1] - grid_m[1][0])
    return float(np.count_nonzero(islands == islands[peak]) * cell)


@checked
def envelope(signal: FloatArray) -> FloatArray:
    """Magnitude of the analytic signal along the last axis."""
    from scipy.signal import hilbert

    whole("envelope", lowest=1, signal=np.size(signal))
    return np.asarray(np.abs(hilbert(signal, axis=-1)))


@checked
def temporal_width_s(signal_m: Vector, rate_hz: float, level: float = HALF) -> float:
    """Full width in time of the envelope around its peak, at `level` times the peak."""
    positive("temporal_width_s", rate_hz=rate_hz)
    return width_m(np.arange(len(signal_m)) / rate_hz, envelope(signal_m), level)


@checked
def uniformity(amplitudes_m: Vector) -> float:
    """1 - standard deviation / mean over focus positions; 1 is an even screen."""
    amplitudes = np.abs(np.asarray(amplitudes_m, float))
    if amplitudes.size < 2 or not amplitudes.any():
        raise InvalidParameter(f"amplitudes_m: found {amplitudes.size} values, expected two or more, not all zero")
    return 1 - float(np.std(amplitudes, ddof=1) / np.mean(amplitudes))


def _ratio(amplitude: float, field: FloatArray) -> float:
    rms = math.sqrt(float(np.mean(np.square(field)))) if np.size(field) else 0.0
    if rms == 0.0:
        raise InvalidParameter("field: found zero everywhere, expected a field to compare the focus with")
    return abs(amplitude) / rms


def _crossing(at: FloatArray, relative: FloatArray, level: float) -> float:
    below = np.flatnonzero(relative < level)
    if below.size == 0:
        raise InvalidParameter(f"profile: found no point below {level} of the peak, expected a longer line")
    i = int(below[0])
    positive("width_m", profile=float(relative[i - 1] - relative[i]))
    share = (relative[i - 1] - level) / (relative[i - 1] - relative[i])
    return float(at[i - 1] + share * (at[i] - at[i - 1]))
