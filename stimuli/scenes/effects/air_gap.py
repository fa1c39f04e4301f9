"""Air between the insulator and the skin."""

from dataclasses import dataclass

from ...composition.content import VoltageContent
from ...composition.effect import Alteration, Surroundings


@dataclass(frozen=True)
class AirGap(Alteration):
    """An air gap between insulator and skin.

    Parameters
    ----------
    gap_m : float
        Thickness of the air between insulator and skin, above 0.
    """

    kind = "air_gap"
    slot = "gap"
    positive = ("gap_m",)
    reads, gives = ("skin",), "skin"
    assumes = ("the gap is uniform under the contact",)

    gap_m: float

    def in_voltage(self, scene: Surroundings) -> VoltageContent:
        return VoltageContent(gap_m=self.gap_m)
