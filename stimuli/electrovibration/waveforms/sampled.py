"""A voltage of any shape, stated by its samples."""

from dataclasses import dataclass

import numpy as np

from tactometry.arguments import require

from ...arrays import FloatArray
from ...perception.detection import components
from .pieces import Pieces, straight
from .waveform import LevelUnit, Ramped


@dataclass(frozen=True)
class Sampled(Ramped):
    """Samples of any shape, scaled to the peak of the level.

    Parameters
    ----------
    shape : tuple of float
        At least two finite values, not all 0; their largest magnitude corresponds to the peak.
    rate_hz, ramp_s, level_unit
        As in `Sine`; without ramps by default.

    >>> Sampled((0.0, 2.0, -4.0, 0.0), rate_hz=100.0).at(0.0).samples.tolist()
    [[0.0, 0.5, -1.0, 0.0]]
    """

    shape: tuple[float, ...]
    rate_hz: float
    ramp_s: float = 0.0
    level_unit: LevelUnit = "dB re 1 V"

    def __post_init__(self) -> None:
        require.positive("Sampled", rate_hz=self.rate_hz)
        values = require.finite_array("Sampled.shape", self.shape)
        enough = values.ndim == 1 and values.size >= 2 and bool(values.any())
        require.expect(enough, "Sampled.shape", f"shape {values.shape}", "at least two samples, not all 0")
        super().__post_init__()

    @property
    def duration_s(self) -> float:
        return len(self.shape) / self.rate_hz

    @property
    def voltage_frequency_hz(self) -> float:
        """Frequency of the strongest spectral line; 0 if there is none."""
        return strongest_hz(np.asarray(self.shape), self.rate_hz)

    @property
    def force_frequency_hz(self) -> float:
        """Strongest spectral line of the squared samples; 0 if there is none.

        The square is computed at twice the rate to avoid aliasing.

        >>> t_s = np.arange(20_000) / 20_000
        >>> Sampled(tuple(np.sin(2 * np.pi * 9900 * t_s)), rate_hz=20_000.0).force_frequency_hz
        19800.0
        """
        from scipy.signal import resample  # slow import

        finer = resample(np.asarray(self.shape, dtype=np.float64), 2 * len(self.shape))
        return strongest_hz(finer**2, 2 * self.rate_hz)

    def pieces(self, level: float) -> Pieces:
        """Return the lines between the samples, from the first to the last."""
        return straight(np.arange(len(self.shape)) / self.rate_hz, self.at(level).samples[0])

    def _unit(self) -> FloatArray:
        values = np.asarray(self.shape, dtype=np.float64)
        return np.asarray(values / np.abs(values).max())


def strongest_hz(samples: FloatArray, rate_hz: float) -> float:
    """Return the frequency of the strongest line, or 0 without one.

    >>> round(strongest_hz(np.cos(2 * np.pi * 30 * np.arange(400) / 400), 400.0), 3)
    30.0
    """
    parts = components(samples, rate_hz)
    return float(parts.frequencies_hz[np.argmax(parts.amplitudes)]) if parts.amplitudes.size else 0.0
