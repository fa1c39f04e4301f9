"""The tone that tries or measures an output."""

from typing import Final

import numpy as np

from tactometry.signal import Signal

FREQUENCY_HZ: Final = 100.0


def tone(voltage_v: float, n_channels: int, rate_hz: float, duration_s: float, ramp_s: float) -> Signal:
    """A sine of 100 Hz with a ramp at each end, the same on all channels, (n_channels, n_samples)."""
    times_s = np.arange(round(duration_s * rate_hz)) / rate_hz
    to_an_end_s = np.minimum(times_s, duration_s - times_s)
    ramp = np.sin(np.pi / 2 * np.clip(to_an_end_s / ramp_s, 0, 1)) ** 2
    samples = voltage_v * ramp * np.sin(2 * np.pi * FREQUENCY_HZ * times_s)
    return Signal(np.tile(samples, (n_channels, 1)), rate_hz, "V")
