"""The plate from above: at the focus instant, and over time."""

from collections.abc import Callable

import numpy as np

from ...arrays import FloatArray
from .motion import PlateMotion


def along(side_m: float, n: int) -> Callable[[], FloatArray]:
    """Places along a side, from edge to edge."""
    return lambda: np.linspace(0.0, side_m, n)


def focus_field() -> Callable[[PlateMotion, FloatArray, FloatArray], FloatArray]:
    """(n_x, n_y): displacement at the focus instant (m/V)."""
    return lambda motion, x_m, y_m: motion.modes.field(motion.at_times(np.zeros(1))[:, 0], x_m, y_m)


def frame_times(n_frames: int, span_s: float) -> Callable[[], FloatArray]:
    """Times of the frames of a movie, the focus in the middle."""
    return lambda: np.linspace(-span_s / 2, span_s / 2, n_frames)


def movie() -> Callable[[PlateMotion, FloatArray, FloatArray, FloatArray], FloatArray]:
    """(n_frames, n_x, n_y): displacement (m/V) at times from the focus instant."""

    def frames(motion: PlateMotion, frames_s: FloatArray, x_m: FloatArray, y_m: FloatArray) -> FloatArray:
        draw = motion.modes.frame(x_m, y_m)
        return np.stack([draw(np.ascontiguousarray(amplitudes)) for amplitudes in motion.at_times(frames_s).T])

    return frames
