"""An electrovibration screen under a voltage that is played: from samples to what a finger feels of them."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf
from typing import ClassVar

from tactometry.contact import Contact

from ...composition.effect import Demand, FingerContact, Stage, is_changed
from ...electrovibration.skin.skin import Skin
from ..effects import OF_ELECTROVIBRATION
from ..stages.circuit import of_true_area
from ..stages.reading import spectrum_of_record
from ..stages.record import sampling
from .panel import AREA_M2, ASSUMES, SKIN_MOTION
from .played import PlayedSurface

SAME = "tactometry.stimuli.scenes.stages.circuit:same"
RECORD = "tactometry.stimuli.scenes.stages.record"
FORCE = "tactometry.stimuli.electrovibration.attraction.force:ForceForm.force_n"


@dataclass(frozen=True)
class PlayedElectrovibration(PlayedSurface):
    """A panel that any voltage is played on, one channel of samples.

    What depends on the voltage alone is computed for a contact of 1 m^2: area, friction and lag are factors of its
    components. Where one is not (a body in series, a finger that sticks), its effect asks for the true area, and so
    does one that changes the course of friction.

    Parameters
    ----------
    skin : Skin
        Insulator, corneum and tissue; what leaks, gaps and resists are effects.
    area_m2 : float
        Contact area, as long as no effect makes it depend on force.
    duration_s : float
        How long a record is felt at a time, which its spectrum is read by.

    >>> PlayedElectrovibration().given
    ('signal', 'contact')
    """

    kind = "electrovibration"
    effects = OF_ELECTROVIBRATION
    assumes: ClassVar[Mapping[str, str]] = ASSUMES
    touches = (FingerContact(1.0, 0.05),)

    skin: Skin = field(default_factory=lambda: Skin(corneum_resistivity_ohm_m=inf))
    area_m2: float = AREA_M2
    duration_s: float = 1.0

    def stages(self, scene: Demand) -> tuple[Stage, ...]:
        area, drawn = ("attraction_components", "area_m2", "form_area_m2"), ("form", "layer_voltage_v")
        return (
            Stage("record", ("signal",), "record", f"{RECORD}:recorded", size=sampling),
            Stage("times", ("record",), "t_s", f"{RECORD}:times"),
            Stage("pieces", ("record",), "voltage", f"{RECORD}:pieces"),
            Stage("skin", (), "skin", f"{RECORD}:skin", self._layers()),
            Stage("area", (), "area_m2", SAME, {"area_m2": self.area_m2}),
            Stage("unit_area", (), "form_area_m2", SAME, {"area_m2": 1.0}),
            Stage("layer_voltage", ("record", "form"), "layer_voltage_v", f"{RECORD}:layer_voltage"),
            Stage("attraction", drawn, "electrostatic_force_n", FORCE),
            spectrum_of_record("spectrum", "electrostatic_force_n", area[0]),
            Stage("area_factor", area, area[0], f"{RECORD}:grown"),
            spectrum_of_record("spectrum_of_friction", "friction_force_n", "components"),
            SKIN_MOTION,
            *((of_true_area(),) if is_changed("friction_force_n", scene) else ()),
        )

    def reaches(self, contact: Contact) -> bool:
        """A finger at rest feels no friction."""
        return contact.force_n > 0 and contact.speed_m_per_s > 0

    def _layers(self) -> dict[str, float | tuple[float, ...]]:
        layers = {**vars(self.skin)}
        tissue = layers.pop("tissue")
        return {**layers, "tissue": tuple(vars(tissue).values()) if tissue else ()}
