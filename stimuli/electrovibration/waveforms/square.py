"""A square voltage."""

from dataclasses import dataclass

from tactometry.arguments import require

from .corners import Corners
from .level import LevelUnit
from .periodic import Periodic, check_periodic, check_width


@dataclass(frozen=True)
class Square(Periodic):
    """``+V0`` for `duty` of a period, then ``-V0``. At a duty of 1/2 the force has twice the frequency.

    Parameters
    ----------
    frequency_hz, duration_s, ramp_s, rate_hz, level_unit
        As in `Sine`.
    duty : float
        Share of the period at ``+V0``, between 0 and 1.
    band_limited : bool
        Sample the Fourier series below half of `rate_hz` instead of the edges, so that nothing aliases.

    Raises
    ------
    InvalidParameter
        If a value is outside of its domain.

    >>> Square(frequency_hz=5.0, ramp_s=0.0, rate_hz=20.0, duration_s=0.2).at(0.0).samples.tolist()
    [[1.0, 1.0, -1.0, -1.0]]
    """

    frequency_hz: float
    duration_s: float = 1.0
    ramp_s: float = 0.05
    rate_hz: float = 20_000.0
    duty: float = 0.5
    band_limited: bool = False
    level_unit: LevelUnit = "dB re 1 V"

    def __post_init__(self) -> None:
        check_periodic(self)
        require.between("Square", 0, 1, duty=self.duty)
        check_width(self, "duty", min(self.duty, 1 - self.duty) / self.frequency_hz)

    @property
    def corners(self) -> Corners:
        return Corners((0.0, self.duty, self.duty, 1.0), (1.0, 1.0, -1.0, -1.0))

    @property
    def voltage_frequency_hz(self) -> float:
        return self.frequency_hz
