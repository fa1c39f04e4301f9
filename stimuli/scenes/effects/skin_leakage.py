"""Leakage of the stratum corneum, a high-pass for the voltage."""

from dataclasses import dataclass

from ...composition.content import VoltageContent
from ...composition.effect import Alteration, Stage, Surroundings
from ..stages.circuit import circuit_stage


@dataclass(frozen=True)
class SkinLeakage(Alteration):
    """Resistivity of the stratum corneum, above 0; the default of 20 kohm m is derived from a cut-off of 500 Hz.

    Parameters
    ----------
    corneum_resistivity_ohm_m : float
        Resistivity through which the charge leaks, above 0.
    """

    kind = "skin_leakage"
    slot = "leakage"
    positive = ("corneum_resistivity_ohm_m",)
    reads, gives = ("skin",), "skin"
    assumes = ("the corneum has the same properties at all frequencies",)

    corneum_resistivity_ohm_m: float = 2.0e4

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        return self.stage(), circuit_stage(self.kind)

    def felt_stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        """Return only the change of the skin, as samples are solved exactly."""
        return (self.stage(),)

    def in_voltage(self, scene: Surroundings) -> VoltageContent:
        return VoltageContent(resistivity_ohm_m=self.corneum_resistivity_ohm_m)
