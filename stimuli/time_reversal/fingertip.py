"""A fingertip at rest on the screen: what it answers the plate with."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from tactometry.arguments.annotations import NotNegative
from tactometry.arguments.checked import checked
from tactometry.arguments.require import at_most

from ..defaults import FORCE_EXPONENT, REFERENCE_FORCE_N, RESISTANCE_N_S_PER_M

if TYPE_CHECKING:
    from .responses.load import PlateLoad


@checked
@dataclass(frozen=True)
class Fingertip:
    """A resting fingertip, with resistance R = R_2N (F / 2 N)^p.

    Mass and stiffness follow the same law.

    Parameters
    ----------
    resistance_n_s_per_m : float
        Mechanical resistance (damper) at 2 N, at least 0.
    mass_kg : float
        Moving mass at 2 N, at least 0.
    stiffness_n_per_m : float
        Stiffness (spring) at 2 N, at least 0.
    exponent : float
        From 1/3 (radius of a Hertz contact) to 2/3 (its area); the default of 1/2 has no source.
    """

    resistance_n_s_per_m: NotNegative = RESISTANCE_N_S_PER_M
    mass_kg: NotNegative = 0.0
    stiffness_n_per_m: NotNegative = 0.0
    exponent: NotNegative = FORCE_EXPONENT

    def __post_init__(self) -> None:
        at_most("Fingertip.exponent", self.exponent, 2.0)

    def load(self, at_m: tuple[float, float], force_n: NotNegative = REFERENCE_FORCE_N) -> "PlateLoad":
        """Return the load on the plate at a place under a force; none at 0 N.

        >>> Fingertip().load((0.1, 0.1), 0.5).resistance_n_s_per_m
        5.0
        """
        from .responses.load import PlateLoad

        # 0 ** 0 is 1: with an exponent of 0 a finger that touches nothing would load the plate
        growth = (force_n / REFERENCE_FORCE_N) ** self.exponent if force_n > 0 else 0.0
        at_2_n = self.resistance_n_s_per_m, self.mass_kg, self.stiffness_n_per_m
        return PlateLoad(*at_m, *(growth * part for part in at_2_n))
