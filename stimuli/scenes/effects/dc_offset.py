"""A constant added to the voltage, the peak kept."""

from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite
from typing import TYPE_CHECKING

from tactometry.errors import InvalidParameter

from ...composition.effect import Demand, Effect, Size, Stage, Surroundings

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

    ratio: float

    def __post_init__(self) -> None:
        if not isfinite(self.ratio) or self.ratio == 0:
            raise InvalidParameter(
                f"DcOffset.ratio: found {self.ratio}, expected a finite number other than 0; without an offset leave "
                "the effect out"
            )

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        del scene
        target = f"{__name__}:shifted"
        return (Stage("dc_offset", ("waveform",), "waveform", target, size=self._size),)

    def _size(self, demand: Demand) -> Size:
        if not demand.surface.ramp_s:  # type: ignore[attr-defined]
            raise InvalidParameter(
                "dc_offset: found a constant that is switched on at once (ramp_s = 0), expected ramps; give the "
                "surface a ramp_s above 0"
            )
        return Size({"ratio": self.ratio})


def shifted(ratio: float) -> "Callable[[Waveform], WithOffset]":
    """A waveform with a constant."""
    from ...electrovibration.attraction.offset import WithOffset

    return lambda waveform: WithOffset(waveform, ratio)
