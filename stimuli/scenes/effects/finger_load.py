"""Fingers at rest that load the plate: at the focus, elsewhere, several."""

from dataclasses import dataclass
from math import pi
from typing import Literal

from tactometry.arguments import require

from ...composition.content import PlateContent
from ...composition.effect import Demand, Effect, Setting, Size, Stage, Surroundings, note
from ...defaults import (
    AREA_AT_1N_M2,
    AREA_EXPONENT,
    FORCE_EXPONENT,
    LUMPED,
    REFERENCE_FORCE_N,
    RESISTANCE_N_S_PER_M,
    SHEAR_VISCOSITY_PA_S,
)
from ..stages.circuit import at_voltage
from ..stages.truncation import at_rest, check_on_plate, cut_of, farther, n_frequencies, n_modes, places_m

CONTACT = "tactometry.stimuli.scenes.stages.contact"
PLATE = "tactometry.stimuli.scenes.stages.plate"


@dataclass(frozen=True)
class FingerLoad(Effect):
    """Every contact at rest as damper, mass and spring at a point, which grow with ``(F/2 N)^exponent``.

    A contact without a place is at the focus. The responses were learnt without contacts. The defaults are
    calibrated (`fingertip` in `stimuli/sources.toml`).

    Parameters
    ----------
    resistance_n_s_per_m : float
        Mechanical resistance (damper) of a finger at 2 N.
    mass_kg : float
        Mass of a finger at 2 N.
    stiffness_n_per_m : float
        Stiffness (spring) of a finger at 2 N.
    exponent : float
        How they grow with the force.
    impedance : {"lumped", "tissue"}
        Damper, mass and spring, calibrated; or tissue (`tactometry.stimuli.time_reversal.pulp`), without them.
    area_at_1n_m2 : float
        Contact area of tissue at 1 N.
    area_exponent : float
        How that area grows with the force.
    shear_viscosity_pa_s : float
        Shear viscosity of tissue, 0.3 to 15.
    """

    kind = "finger_load"
    slot = "load"
    cures = note("add the effect finger_load and a contact at rest", "contact_force_n", "contact_displacement_m")
    requires = ("resting contact",)
    excludes = note(
        "a force at a point sinks into a plate with shear without limit; remove 'shear' or 'finger_load'", "shear"
    )
    assumes = (
        "a contact is linear and two-sided: it pulls as well as it presses, and never lifts off",
        "a lumped contact has one mass, damping and stiffness; one of tissue answers the mean motion over its disc",
    )
    rests_on = "the resistance of a finger (calibrated: by the default 2 N take 30 % of a focus, as the thesis found)"

    resistance_n_s_per_m: float = RESISTANCE_N_S_PER_M
    mass_kg: float = 0.0
    stiffness_n_per_m: float = 0.0
    exponent: float = FORCE_EXPONENT
    impedance: Literal["lumped", "tissue"] = LUMPED
    area_at_1n_m2: float = AREA_AT_1N_M2
    area_exponent: float = AREA_EXPONENT
    shear_viscosity_pa_s: float = SHEAR_VISCOSITY_PA_S

    def __post_init__(self) -> None:
        numbers = {name: value for name, value in vars(self).items() if name != "impedance"}
        require.not_negative("FingerLoad", **numbers)
        require.one_of("FingerLoad.impedance", self.impedance, (LUMPED, "tissue"))
        require.positive("FingerLoad", load=self.resistance_n_s_per_m + self.mass_kg + self.stiffness_n_per_m)
        require.positive("FingerLoad", area_at_1n_m2=self.area_at_1n_m2, shear_viscosity_pa_s=self.shear_viscosity_pa_s)

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        needs, n = ("motion", "oversampling"), len(at_rest(scene))
        return (
            Stage("finger_load", ("motion",), "motion", f"{CONTACT}:loaded_motion", size=self._size),
            Stage("contacts", needs, "per_volt_contacts", f"{CONTACT}:contact_displacement", self._places(scene)),
            Stage("contact_forces", needs, "per_volt_forces", f"{CONTACT}:contact_force", {"n": n}),
            at_voltage("contact_displacement", "per_volt_contacts", "contact_displacement_m"),
            at_voltage("contact_force", "per_volt_forces", "contact_force_n"),
        )

    def felt_stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        """Return the stages of a played plate under fingers of one contact."""
        pulp, where = dict(vars(self)), ("setup", "places_m", "contact")
        return (
            Stage("finger_load", ("displacement_m", *where), "displacement_m", f"{PLATE}:under_load", pulp),
            Stage("contact_force", ("signal", *where), "contact_force_n", f"{PLATE}:contact_force", pulp),
        )

    def impedance_ratio(self, scene: Surroundings) -> float:
        """Return the fingers' impedance over the plate's at the top of the band."""
        surface = scene.surface
        omega = 2 * pi * surface.f_max_hz
        if self.impedance != LUMPED:
            return self._tissue_n_s_per_m(scene, omega) / float(surface.plate.point_impedance_n_s_per_m)
        one = self.resistance_n_s_per_m + self.mass_kg * omega + self.stiffness_n_per_m / omega
        grown = sum((touch.force_n / REFERENCE_FORCE_N) ** self.exponent for touch in at_rest(scene))
        return float(one * grown / surface.plate.point_impedance_n_s_per_m)

    def _tissue_n_s_per_m(self, scene: Surroundings, omega: float) -> float:
        import numpy as np

        from ...time_reversal.fingertip import Fingertip

        s, finger = np.array([1j * omega]), Fingertip(**vars(self))
        loads = [
            finger.contact(at_m, touch.force_n) for at_m, touch in zip(places_m(scene), at_rest(scene), strict=True)
        ]
        return float(sum(abs(load.dynamic_stiffness(s)[0]) / omega for load in loads))

    def in_plate(self, scene: Surroundings) -> PlateContent:
        """Return by how much fingers weaken the motion, most far from the focus."""
        ratio = self.impedance_ratio(scene)
        away = any(touch.x_m is not None for touch in at_rest(scene))
        read = any(name.startswith("contact_") for name in scene.outputs)
        far = farther(scene) if away and read else 1.0
        reading = far * (2.0 if "contact_force_n" in scene.outputs else 1.0)
        return PlateContent(1 + ratio, load=ratio, reading=reading, places_m=tuple(places_m(scene)))

    def _size(self, demand: Demand) -> Size:
        check_on_plate(demand)
        ends, touches = demand.once(cut_of), at_rest(demand)
        moved = n_modes(demand, ends.modes_to_hz) * n_frequencies(demand, ends)
        settings = {**self._places(demand), "force_n": tuple(touch.force_n for touch in touches), **vars(self)}
        return Size(settings, n_operations=30.0 * len(touches) * moved)

    def _places(self, scene: Surroundings) -> dict[str, Setting]:
        x_m, y_m = zip(*places_m(scene), strict=True)
        return {"x_m": x_m, "y_m": y_m}
