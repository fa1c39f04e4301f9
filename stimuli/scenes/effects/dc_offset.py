"""A constant added to the voltage, the peak kept."""

from dataclasses import dataclass
from math import isfinite
from typing import TYPE_CHECKING

from tactometry.errors import InvalidParameter

from ...composition.content import VoltageContent
from ...composition.effect import Demand, Effect, Size, Surroundings

if TYPE_CHECKING:
    from ...electrovibration.attraction.offset import WithOffset
    from ...electrovibration.waveforms.waveform import Waveform


@dataclass(frozen=True)
class DcOffset(Effect):
    """A constant of `ratio` times the peak of the waveform, of either sign but not 0.

    >>> DcOffset(0.5).slot
    'offset'
    """

    kind = "dc_offset"
    slot = "offset"
    reads, gives = ("waveform",), "waveform"
    in_signal = True

    ratio: float

    def __post_init__(self) -> None:
        if not isfinite(self.ratio) or self.ratio == 0:
            raise InvalidParameter(
                f"DcOffset.ratio: found {self.ratio}, expected a finite number other than 0; without an offset leave "
                "the effect out"
            )

    def __call__(self, waveform: "Waveform") -> "WithOffset":
        from ...electrovibration.attraction.offset import WithOffset

        return WithOffset(waveform, self.ratio)

    def size(self, demand: Demand) -> Size:
        if not demand.surface.ramp_s:
            raise InvalidParameter(
                "dc_offset: found a constant that is switched on at once (ramp_s = 0), expected ramps; give the "
                "tone a ramp_s above 0"
            )
        return Size()

    def in_voltage(self, scene: Surroundings) -> VoltageContent:
        return VoltageContent(constant=abs(self.ratio))
