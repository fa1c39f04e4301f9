"""Signals that a moving finger weakens: how strong each sample is follows from where the finger is."""

from typing import Any, Protocol, runtime_checkable

import numpy as np

from .gates import triangle
from .signal import FloatArray, Signal, Stimulus


@runtime_checkable
class FollowsFinger(Stimulus, Protocol):
    """A stimulus whose signal `at` a level is the strongest that it can become: places take a part of it.

    No two samples of the part differ by more than their distance over `rise_s`.
    """

    rise_s: float

    def parts(self, x_m: FloatArray, before: Any = None) -> tuple[FloatArray, Any]:
        """Parts (0..1) of the voltage at places (n_samples,) along the path, one a sample of the signal, and what is to
        be remembered of them: `before` for the places that come next."""

    def check_motion(self, speed_m_per_s: float, positions_hz: float | None = None) -> None:
        """Refuse a speed at which the texture passes faster than the carrier shows, or than positions are reported."""


def felt_under(stimulus: Stimulus, signal: Signal, times_s: FloatArray, positions_m: FloatArray) -> Signal:
    """What a signal of a stimulus becomes under a finger that was at `positions_m` at `times_s` of it.

    Other stimuli do not follow a finger: their signal stays.
    """
    if not isinstance(stimulus, FollowsFinger):
        return signal
    at_s = np.arange(signal.samples.shape[1]) / signal.rate_hz
    parts, _ = stimulus.parts(np.interp(at_s, times_s, positions_m))
    return Signal(signal.samples * parts, signal.rate_hz, signal.unit)


def straight_way(duration_s: float, speed_m_per_s: float, length_m: float) -> tuple[FloatArray, FloatArray]:
    """Times (s) and positions (m) of a finger that goes out and back over a length at a constant speed.

    >>> straight_way(3.0, 0.1, 0.1)[1].round(9).tolist()
    [0.0, 0.1, 0.0, 0.1]
    """
    turns_s = np.arange(0.0, duration_s, length_m / speed_m_per_s) if speed_m_per_s else np.zeros(1)
    times_s = np.append(turns_s, duration_s)
    return times_s, triangle(speed_m_per_s * times_s, length_m)
