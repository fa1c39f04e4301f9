"""A triangular voltage."""

from dataclasses import dataclass

from .corners import Corners
from .level import LevelUnit
from .periodic import Periodic, check_periodic


@dataclass(frozen=True)
class Triangle(Periodic):
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
        check_periodic(self)

    @property
    def corners(self) -> Corners:
        return Corners((0.0, 0.25, 0.75, 1.0), (0.0, 1.0, -1.0, 0.0))

    @property
    def voltage_frequency_hz(self) -> float:
        return self.frequency_hz
