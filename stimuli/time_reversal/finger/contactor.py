"""Contactors pressed on the plate in place of a finger: soft and rigid tips of some diameter.

Each spreads over a disc: seven points (the centre and six on 2/3 of the radius) share its impedance. All
constants are unverified defaults; the thesis's contactors are not known.
"""

import math
from dataclasses import dataclass
from typing import Final

from tactometry.arguments.checked import checked
from tactometry.arguments.require import not_negative, one_of, positive

from ..plate.plate import Plate
from ..responses.load import PlateLoad
from .finger import (
    FORCE_EXPONENT,
    REFERENCE_FORCE_N,
    RESISTANCE_N_S_PER_M,
    Finger,
)

FINGER_DIAMETER_M: Final = 10e-3
"""Diameter of a fingertip's contact at 2 N."""

RIGID_MODULUS_PA: Final = 3e9
"""Modulus of a plastic tip."""

RIGID_MASS_KG: Final = 2e-3
KINDS: Final = ("finger", "soft", "rigid")


@checked
@dataclass(frozen=True)
class Contactor:
    """What presses on the plate.

    Parameters
    ----------
    kind : str
        ``finger``: the lumped default of `Finger`; ``soft``: a finger's resistance per area over its own
        area; ``rigid``: that, and the mass of a tip behind a Hertz contact that stiffens with force.
    diameter_m : float
        Above 0; not used for a finger.
    """

    kind: str
    diameter_m: float = FINGER_DIAMETER_M

    def __post_init__(self) -> None:
        one_of("Contactor.kind", self.kind, KINDS)
        positive("Contactor", diameter_m=self.diameter_m)

    def loads(self, plate: Plate, at_m: tuple[float, float], force_n: float) -> list[PlateLoad]:
        """The loads on the plate under a force (N, at least 0), centred on the plate, the parts beyond an edge left
        out."""
        not_negative("Contactor.loads", force_n=force_n)
        plate.check_holds("at_m", at_m)
        if self.kind == "finger":
            return [Finger(*at_m, force_n).load()]
        return [self._share(x, y, force_n) for x, y in _disc(at_m, self.diameter_m / 2) if plate.contains(x, y)]

    def _share(self, x: float, y: float, force_n: float) -> PlateLoad:
        growth = (force_n / REFERENCE_FORCE_N) ** FORCE_EXPONENT if force_n > 0 else 0.0
        area = (self.diameter_m / FINGER_DIAMETER_M) ** 2
        resistance = RESISTANCE_N_S_PER_M * area * growth / N_POINTS
        if self.kind == "soft" or force_n == 0:
            return PlateLoad(x, y, resistance)
        stiffness = hertz_stiffness_n_per_m(force_n, self.diameter_m / 2) / N_POINTS
        return PlateLoad(x, y, resistance, RIGID_MASS_KG * growth / N_POINTS, stiffness)


@checked
def hertz_stiffness_n_per_m(force_n: float, radius_m: float, modulus_pa: float = RIGID_MODULUS_PA) -> float:
    """Slope of Hertz's law of a sphere, (6 E^2 R F)^(1/3).

    >>> round(hertz_stiffness_n_per_m(1.0, 1e-3, 1e9))
    181712
    """
    not_negative("hertz_stiffness_n_per_m", force_n=force_n)
    positive("hertz_stiffness_n_per_m", radius_m=radius_m, modulus_pa=modulus_pa)
    return float((6 * modulus_pa**2 * radius_m * force_n) ** (1 / 3))


N_POINTS: Final = 7


def _disc(centre_m: tuple[float, float], radius_m: float) -> list[tuple[float, float]]:
    x_m, y_m = centre_m
    ring = [(math.cos(i * math.pi / 3), math.sin(i * math.pi / 3)) for i in range(6)]
    return [centre_m, *((x_m + radius_m * 2 / 3 * c, y_m + radius_m * 2 / 3 * s) for c, s in ring)]
