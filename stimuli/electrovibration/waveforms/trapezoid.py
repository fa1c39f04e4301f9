"""A trapezoidal voltage."""

from dataclasses import dataclass
from itertools import accumulate

from tactometry.arguments import require
from tactometry.errors import InvalidParameter

from .corners import Corners
from .level import LevelUnit
from .periodic import Periodic, check_periodic, check_width


@dataclass(frozen=True)
class Trapezoid(Periodic):
    """From the low value up to ``V0``, hold, down, hold, in straight lines, over and over.

    Parameters
    ----------
    rise_s, high_s, fall_s, low_s : float
        Lengths of the four lines; one of 0 is left out (a jump, or no hold).
    low_ratio : float
        Low value over ``V0``, -1 to 1; 0 (unipolar) is an unverified default.
    duration_s, ramp_s, rate_hz, level_unit
        As in `Sine`, but without ramps by default: the first rise is one.
    band_limited : bool
        Sample the Fourier series below half of `rate_hz` instead of the corners, so that nothing aliases.

    Raises
    ------
    InvalidParameter
        If a value is outside of its domain, or the voltage stays for less than a sample above or below the
        middle of its two values, so that samples may miss it.

    >>> lines = Trapezoid(rise_s=0.1, high_s=0.1, fall_s=0.1, low_s=0.1, rate_hz=10.0, duration_s=0.4)
    >>> lines.at(0.0).samples.round(12).tolist()
    [[0.0, 1.0, 1.0, 0.0]]
    """

    rise_s: float
    high_s: float
    fall_s: float
    low_s: float
    low_ratio: float = 0.0
    duration_s: float = 1.0
    ramp_s: float = 0.0
    rate_hz: float = 20_000.0
    band_limited: bool = False
    level_unit: LevelUnit = "dB re 1 V"

    def __post_init__(self) -> None:
        times = {name: getattr(self, name) for name in ("rise_s", "high_s", "fall_s", "low_s")}
        require.not_negative("Trapezoid", **times)
        if sum(times.values()) == 0:
            raise InvalidParameter("Trapezoid: found four lines of 0 s, expected a period above 0 s")
        require.finite("Trapezoid", low_ratio=self.low_ratio)
        if not -1 <= self.low_ratio <= 1:
            raise InvalidParameter(f"Trapezoid.low_ratio: found {self.low_ratio!r}, expected -1 to 1")
        check_periodic(self)
        edges_s = (self.rise_s + self.fall_s) / 2
        check_width(self, "high_s", self.high_s + edges_s)
        check_width(self, "low_s", self.low_s + edges_s)

    @property
    def frequency_hz(self) -> float:
        return 1 / (self.rise_s + self.high_s + self.fall_s + self.low_s)

    @property
    def corners(self) -> Corners:
        ends = [0.0, *accumulate((self.rise_s, self.high_s, self.fall_s))]
        phases = (*(end * self.frequency_hz for end in ends), 1.0)
        return Corners(phases, (self.low_ratio, 1.0, 1.0, self.low_ratio, self.low_ratio))

    @property
    def voltage_frequency_hz(self) -> float:
        return self.frequency_hz
