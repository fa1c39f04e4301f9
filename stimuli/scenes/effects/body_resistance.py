"""Resistance of body and source in series with the skin."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from ...composition.content import VoltageContent
from ...composition.effect import Effect, Stage, Surroundings
from ..stages.circuit import circuit_stage

if TYPE_CHECKING:
    from ...electrovibration.skin.skin import Skin


@dataclass(frozen=True)
class BodyResistance(Effect):
    """A resistance above 0. With it the waveform of the force depends on the contact area.

    >>> BodyResistance(resistance_ohm=1e4).slot
    'body'
    """

    kind = "body_resistance"
    slot = "body"
    positive = ("resistance_ohm",)
    reads, gives = ("skin",), "skin"

    resistance_ohm: float

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        return self.stage(), circuit_stage(self.kind)

    def __call__(self, skin: "Skin") -> "Skin":
        return replace(skin, body_resistance_ohm=self.resistance_ohm)

    def in_voltage(self, scene: Surroundings) -> VoltageContent:
        return VoltageContent(bare_kinks=1.0)
