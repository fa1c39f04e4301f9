"""A sinusoidal voltage."""

from dataclasses import dataclass

import numpy as np

from tactometry.arguments import require

from ...arrays import FloatArray
from .pieces import Pieces, ramped as ramped_pieces
from .waveform import LevelUnit, Ramped, check_nyquist, peak_voltage_v, times_s


@dataclass(frozen=True)
class Sine(Ramped):
    """A sine ``V0 sin(2 pi f t + phase)``; the force is quadratic and vibrates at ``2 f``.

    Parameters
    ----------
    frequency_hz : float
        Frequency of the voltage, above 0 and below half of `rate_hz`.
    duration_s : float
        Whole length, ramps included.
    ramp_s : float
        Length of the raised-cosine ramps at onset and offset; the default of 50 ms is a choice.
    rate_hz : float
        Samples per second; the default of 20 kHz leaves room for the doubled bandwidth of the force.
    phase_rad : float
        Phase at time 0.
    level_unit : {"dB re 1 V", "V"}
        Unit of the level: decibel re 1 V peak, or volt peak.

    >>> Sine(frequency_hz=60.0).at(20.0).peak
    10.0
    >>> Sine(frequency_hz=60.0).force_frequency_hz
    120.0
    """

    frequency_hz: float
    duration_s: float = 1.0
    ramp_s: float = 0.05
    rate_hz: float = 20_000.0
    phase_rad: float = 0.0
    level_unit: LevelUnit = "dB re 1 V"

    def __post_init__(self) -> None:
        require.positive("Sine", frequency_hz=self.frequency_hz)
        require.finite("Sine", phase_rad=self.phase_rad)
        super().__post_init__()
        check_nyquist("Sine", "frequency_hz", self.frequency_hz, self.rate_hz)

    @property
    def voltage_frequency_hz(self) -> float:
        return self.frequency_hz

    @property
    def force_frequency_hz(self) -> float:
        return 2 * self.frequency_hz

    def _unit(self) -> FloatArray:
        return np.sin(2 * np.pi * self.frequency_hz * times_s(self.duration_s, self.rate_hz) + self.phase_rad)

    def pieces(self, level: float) -> Pieces:
        """Return the exact voltage as pieces, ramps included."""
        c = -1j * np.exp(1j * self.phase_rad) * peak_voltage_v(level, self.level_unit)
        zero, f_hz = np.zeros(1), np.array([self.frequency_hz])
        tone = Pieces(zero, self.duration_s, zero, zero, f_hz, np.array([[c]]))
        return ramped_pieces(tone, self.ramp_s)
