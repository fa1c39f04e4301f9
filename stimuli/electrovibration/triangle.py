"""A triangular voltage."""

from dataclasses import dataclass

from tactometry.signal import Signal
from tactometry.stimuli.electrovibration.corners import Corners
from tactometry.stimuli.electrovibration.level import LevelUnit, peak_voltage_v
from tactometry.stimuli.electrovibration.periodic import check_periodic, periodic_pieces, periodic_signal
from tactometry.stimuli.electrovibration.pieces import Pieces


@dataclass(frozen=True)
class Triangle:
    """From 0 to ``V0``, to ``-V0`` and back, in straight lines; the force has twice the frequency.

    Parameters
    ----------
    frequency_hz, duration_s, ramp_s, rate_hz, level_unit
        As in `Sine`.
    band_limited : bool
        Sample the Fourier series below half of `rate_hz` instead of the corners, so that nothing aliases.

    Raises
    ------
    InvalidParameter
        If a value is outside of its domain.

    >>> Triangle(frequency_hz=5.0, ramp_s=0.0, rate_hz=20.0, duration_s=0.2).at(0.0).samples.tolist()
    [[0.0, 1.0, 0.0, -1.0]]
    """

    frequency_hz: float
    duration_s: float = 1.0
    ramp_s: float = 0.05
    rate_hz: float = 20_000.0
    band_limited: bool = False
    level_unit: LevelUnit = "dB re 1 V"

    def __post_init__(self) -> None:
        check_periodic(
            "Triangle",
            self.frequency_hz,
            duration_s=self.duration_s,
            ramp_s=self.ramp_s,
            rate_hz=self.rate_hz,
            level_unit=self.level_unit,
        )

    @property
    def corners(self) -> Corners:
        return Corners((0.0, 0.25, 0.75, 1.0), (0.0, 1.0, -1.0, 0.0))

    @property
    def voltage_frequency_hz(self) -> float:
        return self.frequency_hz

    @property
    def force_frequency_hz(self) -> float:
        return (2 if self.corners.is_antisymmetric else 1) * self.frequency_hz

    def at(self, level: float) -> Signal:
        """(1, n_samples) volt; no sample passes the peak that `level` states."""
        return periodic_signal(
            self.corners,
            self.frequency_hz,
            peak_v=peak_voltage_v(level, self.level_unit),
            duration_s=self.duration_s,
            ramp_s=self.ramp_s,
            rate_hz=self.rate_hz,
            band_limited=self.band_limited,
        )

    def pieces(self, level: float) -> Pieces:
        """The voltage exactly."""
        return periodic_pieces(
            self.corners,
            self.frequency_hz,
            duration_s=self.duration_s,
            ramp_s=self.ramp_s,
            level=level,
            unit=self.level_unit,
        )
