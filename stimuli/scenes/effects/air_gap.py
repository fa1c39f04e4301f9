"""Air between the insulator and the skin."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from ...composition.content import VoltageContent
from ...composition.effect import Effect, Surroundings

if TYPE_CHECKING:
    from ...electrovibration.skin.skin import Skin


@dataclass(frozen=True)
class AirGap(Effect):
    """A gap of `gap_m`, above 0.

    >>> AirGap(gap_m=1e-6).slot
    'gap'
    """

    kind = "air_gap"
    slot = "gap"
    positive = ("gap_m",)
    reads, gives = ("skin",), "skin"
    assumes = ("the gap is even under the whole contact",)

    gap_m: float

    def __call__(self, skin: "Skin") -> "Skin":
        return replace(skin, gap_m=self.gap_m)

    def in_voltage(self, scene: Surroundings) -> VoltageContent:
        return VoltageContent(gap_m=self.gap_m)
