"""Dynamics of the finger pad, proportional to the speed."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import sqrt
from typing import TYPE_CHECKING, Any

from ...composition.content import VoltageContent
from ...composition.effect import Effect, Stage, Surroundings, note
from ...composition.sampling import per_sample
from ..stages.circuit import of_true_area, spectrum_of_record, spectrum_stage

if TYPE_CHECKING:
    from ...arrays import FloatArray
    from ...electrovibration.motion.finger import Motion
    from ...electrovibration.motion.stick_slip import StickSlip

OUTPUTS: Mapping[bool, Mapping[str, str]] = {
    True: {"lateral_n": "friction_force_n", "stretch_m": "skin_displacement_m", "events_s": "slip_events_s"},
    False: {"deflection_m": "skin_displacement_m"},  # in full slip friction does not depend on the motion
}
"""Quantities by the name of their time course, for a finger that sticks and one that slides."""


@dataclass(frozen=True)
class FingerDynamics(Effect):
    """Finger pad with the mass and stiffness published per sliding speed; the damping is an unverified default.

    The motion of this pad is felt instead of that of `skin_mobility`, and the pad does not depend on the normal force.
    With `friction` the finger always slides, and the effect does not change its friction. With `dry_friction` it sticks
    and slips.

    Parameters
    ----------
    damping_n_s_per_m : float
        Damping of the finger pulp.
    """

    kind = "finger_dynamics"
    slot = "dynamics"
    requires = ("friction", "sliding contact")
    cures = note("add the effects dry_friction and finger_dynamics", "slip_events_s") | note(
        "add the effects friction (or dry_friction) and finger_dynamics", "skin_displacement_m"
    )
    not_negative = ("damping_n_s_per_m",)
    assumes = ("the pad is one mass, spring and damper; its damping is unverified",)

    damping_n_s_per_m: float = 1.5

    @property
    def natural_rad_per_s(self) -> float:
        """Natural frequency of the undamped pad, the same at all speeds.

        Mass and stiffness are both proportional to speed.

        >>> round(FingerDynamics().natural_rad_per_s)
        354
        """
        from ...electrovibration.motion.pad import MASS_KG_PER_M_PER_S, STIFFNESS_N_S_PER_M2

        return sqrt(STIFFNESS_N_S_PER_M2 / MASS_KG_PER_M_PER_S)

    def in_voltage(self, scene: Surroundings) -> VoltageContent:
        return VoltageContent(swing_rad_per_s=self.natural_rad_per_s)

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        friction = scene.find("friction")
        sticks = friction is not None and friction.kind == "dry_friction"
        motion = Stage(
            "stick_slip" if sticks else "finger_motion",
            ("t_s", "voltage", "form", "friction_law", "contact"),
            "motion",
            f"{__name__}:{'stick_and_slip' if sticks else 'slide'}",
            dict(vars(self)),
            size=per_sample(500.0 if sticks else 250.0),
        )
        felt = spectrum_stage("skin_spectrum", "skin_displacement_m", "skin_components")
        read = f"{__name__}:read"
        courses = [
            Stage(quantity, ("motion",), quantity, read, {"name": name}) for name, quantity in OUTPUTS[sticks].items()
        ]
        return motion, *courses, felt

    def felt_stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        """Return stages of a time course, as the pad is nonlinear in the attraction."""
        *course, _ = (replace(stage, size=None) for stage in self.stages(scene))
        return *course, spectrum_of_record("skin_spectrum", "skin_displacement_m", "skin_components"), of_true_area()


def slide(*drive: Any, damping_n_s_per_m: float) -> "Motion":
    from ...electrovibration.motion.finger import sliding
    from ...electrovibration.motion.pad import Finger

    *attraction, friction, contact = drive
    finger = Finger.at_speed(contact.speed_m_per_s, damping_n_s_per_m)
    return sliding(*attraction, finger=finger, friction=friction, force_n=contact.force_n)


def stick_and_slip(*drive: Any, damping_n_s_per_m: float) -> "StickSlip":
    from ...electrovibration.motion.pad import Finger
    from ...electrovibration.motion.stick_slip import Travel, stick_slip

    *attraction, friction, contact = drive
    finger, travel = Finger.at_speed(contact.speed_m_per_s, damping_n_s_per_m), Travel(contact.speed_m_per_s)
    return stick_slip(*attraction, finger=finger, friction=friction, force_n=contact.force_n, travel=travel)


def read(motion: "Motion | StickSlip", name: str) -> "FloatArray":
    """Return one time course of a motion."""
    course: FloatArray = getattr(motion, name)
    return course
