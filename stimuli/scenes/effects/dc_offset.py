"""A constant added to the voltage at an unchanged peak."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from tactometry.arguments import require

from ...composition.content import VoltageContent
from ...composition.effect import Demand, Effect, Size, Surroundings

if TYPE_CHECKING:
    from ...electrovibration.attraction.offset import WithOffset
    from ...electrovibration.waveforms.waveform import Waveform

LARGEST: Final = 1e6
"""Largest ratio: a constant a million times the tone leaves nothing of the tone."""


@dataclass(frozen=True)
class DcOffset(Effect):
    """A constant voltage of `ratio` times the peak of the waveform.

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
        sized = f"a number from {-LARGEST:g} to {LARGEST:g} other than 0; omit the effect if there is no offset"
        require.expect(0 < abs(self.ratio) <= LARGEST, "DcOffset.ratio", self.ratio, sized)

    def __call__(self, waveform: "Waveform") -> "WithOffset":
        from ...electrovibration.attraction.offset import WithOffset

        return WithOffset(waveform, self.ratio)

    def size(self, demand: Demand) -> Size:
        found = "a constant without a ramp (ramp_s = 0)"
        require.expect(demand.surface.ramp_s, "dc_offset", found, "ramps; set ramp_s of the tone above 0")
        return Size()

    def in_voltage(self, scene: Surroundings) -> VoltageContent:
        return VoltageContent(constant=abs(self.ratio))
