"""A voltage step with a chosen rise time."""

from dataclasses import dataclass

import numpy as np

from tactometry.arguments import require
from tactometry.signal import Signal

from .pieces import Pieces, straight
from .waveform import LevelUnit, Ramped, check_pulse, n_samples, peak_voltage_v, times_s


@dataclass(frozen=True)
class Step(Ramped):
    """A step: 0 until `onset_s`, rise to ``V0`` in `rise_s`, hold, fall to 0 in `fall_s` before the end.

    Raises `InvalidParameter` if a value is outside of its domain, the parts are longer than the whole, or the voltage
    stays for less than a sample above ``V0 / 2``, so that samples may miss it.

    Parameters
    ----------
    onset_s : float
        Start of the rise.
    rise_s : float
        Duration of the rise; 0 is a jump, which the samples draw as a line over one sample.
    fall_s : float
        Duration of the fall; 0 is a jump, which the samples draw as a line over one sample.
    duration_s, rate_hz, level_unit
        As in `Sine`.

    >>> Step(onset_s=0.1, duration_s=0.4, rate_hz=10.0).at(20.0).samples.tolist()
    [[0.0, 10.0, 10.0, 10.0]]
    """

    onset_s: float = 0.0
    rise_s: float = 0.0
    fall_s: float = 0.0
    duration_s: float = 1.0
    rate_hz: float = 20_000.0
    level_unit: LevelUnit = "dB re 1 V"

    def __post_init__(self) -> None:
        require.not_negative("Step", onset_s=self.onset_s, rise_s=self.rise_s, fall_s=self.fall_s)
        super().__post_init__()
        parts_s = self.onset_s + self.rise_s + self.fall_s
        less = f"less than duration_s ({self.duration_s} s); lengthen the signal"
        require.expect(parts_s < self.duration_s, "Step", f"onset, rise and fall of {parts_s} s in total", less)
        end_s = min(self.duration_s - self.fall_s / 2, n_samples(self.duration_s, self.rate_hz) / self.rate_hz)
        width_s = end_s - self.onset_s - self.rise_s / 2
        check_pulse("Step.duration_s", width_s, self.rate_hz, "lengthen it or raise rate_hz")

    @property
    def ramp_s(self) -> float:
        """0, as rise and fall act as ramps."""
        return 0.0

    @property
    def voltage_frequency_hz(self) -> float:
        """0, as a step has no frequency."""
        return 0.0

    @property
    def force_frequency_hz(self) -> float:
        return 0.0

    def at(self, level: float) -> Signal:
        """Return the samples (1, n_samples) in volt."""
        samples = self.pieces(level).at(np.round(times_s(self.duration_s, self.rate_hz), 12))
        return Signal(samples[None, :], self.rate_hz, "V")

    def pieces(self, level: float) -> Pieces:
        """Return the exact voltage as pieces."""
        peak_v = peak_voltage_v(level, self.level_unit)
        up_s = self.onset_s + self.rise_s
        t_s = [0.0, self.onset_s, up_s, self.duration_s - self.fall_s, self.duration_s]
        return straight(t_s, [0.0, 0.0, peak_v, peak_v, 0.0])
