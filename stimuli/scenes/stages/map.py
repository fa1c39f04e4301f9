"""The plate from above: at the focus instant, and over time."""

import numpy as np

from ...arrays import FloatArray
from .motion import PlateMotion


def along(side_m: float, n: int) -> FloatArray:
    """Places along a side, from edge to edge."""
    return np.linspace(0.0, side_m, n)


def focus_field(motion: PlateMotion, x_m: FloatArray, y_m: FloatArray) -> FloatArray:
    """(n_x, n_y): displacement at the focus instant (m/V)."""
    return motion.modes.field(motion.at_times(np.zeros(1))[:, 0], x_m, y_m)


def frame_times(n_frames: int, span_s: float) -> FloatArray:
    """Times of the frames of a movie, the focus in the middle."""
    return np.linspace(-span_s / 2, span_s / 2, n_frames)


def movie(motion: PlateMotion, frames_s: FloatArray, x_m: FloatArray, y_m: FloatArray) -> FloatArray:
    """(n_frames, n_x, n_y): displacement (m/V) at times from the focus instant."""
    draw = motion.modes.frame(x_m, y_m)
    return np.stack([draw(np.ascontiguousarray(amplitudes)) for amplitudes in motion.at_times(frames_s).T])
