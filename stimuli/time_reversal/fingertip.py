"""Mechanical load of a fingertip that rests on the screen."""

from dataclasses import dataclass
from math import pi, sqrt
from typing import TYPE_CHECKING, Literal

from tactometry.arguments.checked import NotNegative, Positive, checked
from tactometry.arguments.require import at_most, expect, one_of

from ..defaults import (
    AREA_AT_1N_M2,
    AREA_EXPONENT,
    FORCE_EXPONENT,
    LUMPED,
    REFERENCE_FORCE_N,
    RESISTANCE_N_S_PER_M,
    SHEAR_VISCOSITY_PA_S,
)

if TYPE_CHECKING:
    from .pulp import PulpLoad
    from .responses.load import PlateLoad


@checked
@dataclass(frozen=True)
class Fingertip:
    """A resting fingertip, with resistance R = R_2N (F / 2 N)^p.

    Mass and stiffness follow the same law. They are not used by ``tissue``.

    Parameters
    ----------
    impedance : {"lumped", "tissue"}
        Damper, mass and spring, calibrated; or soft tissue under a disc with the contact area (`PulpLoad`).
    resistance_n_s_per_m : float
        Mechanical resistance (damper) at 2 N, at least 0.
    mass_kg : float
        Moving mass at 2 N, at least 0.
    stiffness_n_per_m : float
        Stiffness (spring) at 2 N, at least 0.
    exponent : float
        Between 1/3 (radius of a Hertz contact) and 1 (stiffness in proportion to the force, Pataky et al. 2005).
    area_at_1n_m2 : float
        Contact area of tissue at 1 N.
    area_exponent : float
        Exponent with which that area grows with the force.
    shear_viscosity_pa_s : float
        Shear viscosity of tissue, Pa s.
    """

    resistance_n_s_per_m: NotNegative = RESISTANCE_N_S_PER_M
    mass_kg: NotNegative = 0.0
    stiffness_n_per_m: NotNegative = 0.0
    exponent: NotNegative = FORCE_EXPONENT
    impedance: Literal["lumped", "tissue"] = LUMPED
    area_at_1n_m2: Positive = AREA_AT_1N_M2
    area_exponent: NotNegative = AREA_EXPONENT
    shear_viscosity_pa_s: Positive = SHEAR_VISCOSITY_PA_S

    def __post_init__(self) -> None:
        one_of("Fingertip.impedance", self.impedance, (LUMPED, "tissue"))
        at_most("Fingertip.exponent", self.exponent, 2.0)
        at_most("Fingertip.area_exponent", self.area_exponent, 2.0)

    def load(self, at_m: tuple[float, float], force_n: NotNegative = REFERENCE_FORCE_N) -> "PlateLoad":
        """Return the lumped load on the plate at a place and a force; it is zero at 0 N.

        >>> Fingertip().load((0.1, 0.1), 0.5).resistance_n_s_per_m
        5.0
        """
        from .responses.load import PlateLoad

        expected = "'lumped' where contacts open; a contact of tissue is linear"
        expect(self.impedance == LUMPED, "Fingertip.impedance", repr(self.impedance), expected)
        # 0 ** 0 is 1: with an exponent of 0 a finger that touches nothing would load the plate
        growth = (force_n / REFERENCE_FORCE_N) ** self.exponent if force_n > 0 else 0.0
        at_2_n = self.resistance_n_s_per_m, self.mass_kg, self.stiffness_n_per_m
        return PlateLoad(*at_m, *(growth * part for part in at_2_n))

    def contact(self, at_m: tuple[float, float], force_n: NotNegative) -> "PlateLoad | PulpLoad":
        """Return the load of either kind of impedance; it is zero at 0 N.

        >>> round(1e3 * Fingertip(impedance="tissue").contact((0.1, 0.1), 1.0).radius_m, 2)
        5.64
        """
        if self.impedance == LUMPED:
            return self.load(at_m, force_n)
        if force_n == 0:
            from .responses.load import PlateLoad

            return PlateLoad(*at_m)
        from .pulp import PulpLoad, Tissue

        area_m2 = self.area_at_1n_m2 * force_n**self.area_exponent
        return PulpLoad(*at_m, sqrt(area_m2 / pi), Tissue(shear_viscosity_pa_s=self.shear_viscosity_pa_s))
