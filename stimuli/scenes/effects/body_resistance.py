"""Resistance of body and source in series with the skin."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from ...composition.content import VoltageContent
from ...composition.effect import Alteration, Stage, Surroundings
from ..stages.circuit import circuit_stage, of_true_area


@dataclass(frozen=True)
class BodyResistance(Alteration):
    """A series resistance, which makes the waveform of the force depend on the contact area.

    Parameters
    ----------
    resistance_ohm : float
        Series resistance of the body and the source, above 0.
    """

    kind = "body_resistance"
    slot = "body"
    positive = ("resistance_ohm",)
    reads, gives = ("skin",), "skin"
    sets: ClassVar[Mapping[str, str]] = {"resistance_ohm": "body_resistance_ohm"}

    resistance_ohm: float

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        return self.stage(), circuit_stage(self.kind)

    def felt_stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        """Return stages at the true area, which sets the charging time."""
        return self.stage(), of_true_area()

    def in_voltage(self, scene: Surroundings) -> VoltageContent:
        return VoltageContent(bare_kinks=1.0)
