"""How a focus is made: band, reversal time, rate, voltage, quantiser."""

from collections.abc import Sequence
from dataclasses import dataclass

from tactometry.arguments.checked import checked
from tactometry.arguments.require import positive
from tactometry.errors import InvalidParameter

from ..filters import Band
from ..responses.filtering import band_limited
from ..responses.load import Attached, loaded_responses
from ..responses.responses import Point, Responses, samples_in
from ..screen.screen import Screen
from .quantiser import Quantiser


@checked
@dataclass(frozen=True)
class Emission:
    """How a focus is made: band, T, sampling and voltage, each above 0, and quantiser."""

    band: Band
    reversal_s: float
    rate_hz: float
    voltage_v: float = 30.0
    quantiser: Quantiser | None = None

    def __post_init__(self) -> None:
        positive("Emission", reversal_s=self.reversal_s, rate_hz=self.rate_hz, voltage_v=self.voltage_v)
        if samples_in("Emission.reversal_s", self.reversal_s, self.rate_hz) == 0:
            raise InvalidParameter(
                f"Emission.reversal_s: found {self.reversal_s}, expected at least half a sample of 1 / {self.rate_hz} s"
            )
        if 2 * self.band.f_max_hz > self.rate_hz:
            raise InvalidParameter(
                f"Emission.band: found {self.band.f_max_hz} Hz, above the Nyquist frequency {self.rate_hz / 2}; "
                "raise rate_hz or lower the band"
            )

    @property
    def f_max_hz(self) -> float:
        """Modes up to a tenth above the band, within the Nyquist frequency."""
        return min(1.1 * self.band.f_max_hz, self.rate_hz / 2)

    def responses(self, screen: Screen, points: Sequence[Point], loads: Sequence[Attached] = ()) -> Responses:
        """Responses of the screen over T, within the band."""
        raw = loaded_responses(
            screen, points, loads, rate_hz=self.rate_hz, duration_s=self.reversal_s, f_max_hz=self.f_max_hz
        )
        return band_limited(raw, self.band)
