"""Air between the insulator and the skin."""

from dataclasses import dataclass

from ...composition.content import VoltageContent
from ...composition.effect import Alteration, Surroundings


@dataclass(frozen=True)
class AirGap(Alteration):
    """A gap of `gap_m`, above 0.

    Parameters
    ----------
    gap_m : float
        Thickness of the air between insulator and skin, above 0.
    """

    kind = "air_gap"
    slot = "gap"
    positive = ("gap_m",)
    reads, gives = ("skin",), "skin"
    assumes = ("the gap is even under the whole contact",)

    gap_m: float

    def in_voltage(self, scene: Surroundings) -> VoltageContent:
        return VoltageContent(gap_m=self.gap_m)
