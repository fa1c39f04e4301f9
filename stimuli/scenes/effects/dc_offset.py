"""A constant added to the voltage, the peak kept."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from tactometry.arguments import require

from ...composition.content import VoltageContent
from ...composition.effect import Demand, Effect, Size, Surroundings

if TYPE_CHECKING:
    from ...electrovibration.attraction.offset import WithOffset
    from ...electrovibration.waveforms.waveform import Waveform

LARGEST: Final = 1e6
"""A constant a million times the tone leaves nothing of it."""


@dataclass(frozen=True)
class DcOffset(Effect):
    """A constant of `ratio` times the peak of the waveform, of either sign but not 0.

    Parameters
    ----------
    ratio : float
        Constant voltage divided by the peak of the waveform, of either sign but not 0.
    """

    kind = "dc_offset"
    slot = "offset"
    reads, gives = ("waveform",), "waveform"
    in_signal = True

    ratio: float

    def __post_init__(self) -> None:
        sized = f"a number from {-LARGEST:g} to {LARGEST:g} other than 0; without an offset leave the effect out"
        require.expect(0 < abs(self.ratio) <= LARGEST, "DcOffset.ratio", self.ratio, sized)

    def __call__(self, waveform: "Waveform") -> "WithOffset":
        from ...electrovibration.attraction.offset import WithOffset

        return WithOffset(waveform, self.ratio)

    def size(self, demand: Demand) -> Size:
        found = "a constant that is switched on at once (ramp_s = 0)"
        require.expect(demand.surface.ramp_s, "dc_offset", found, "ramps; give the tone a ramp_s above 0")
        return Size()

    def in_voltage(self, scene: Surroundings) -> VoltageContent:
        return VoltageContent(constant=abs(self.ratio))
