"""A fingertip at rest on the screen: its impedance, and the focus that it feels at threshold.

Facts (thesis): 2 N elsewhere than the focus cost 6 % of amplitude, 2 N at the focus up to 30 %. The
default, a damper of 10 N s/m at 2 N with tau = 3.5 ms, is set to meet both in simulation: it is neither
measured nor a prediction. The force law is an unverified default.

Effects of scenes take their defaults from here, so no physics is imported before a load is asked for.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from tactometry.arguments.annotations import NotNegative
from tactometry.arguments.checked import checked
from tactometry.arguments.require import at_most

if TYPE_CHECKING:
    from .responses.load import PlateLoad

REFERENCE_FORCE_N: Final = 2.0
RESISTANCE_N_S_PER_M: Final = 10.0
FORCE_EXPONENT: Final = 0.5

FOCUS_AT_THRESHOLD_M: Final = 10e-6
"""Amplitude of a single focus that is just felt (the thesis: about 10 um); unverified default."""


@checked
@dataclass(frozen=True)
class Fingertip:
    """What a fingertip at rest answers the plate with: R = R_2N (F / 2 N)^p, mass and stiffness by the same law.

    Parameters
    ----------
    resistance_n_s_per_m, mass_kg, stiffness_n_per_m : float
        At 2 N, at least 0.
    exponent : float
        From 1/3 (radius of a Hertz contact) to 2/3 (its area); unverified default 1/2.
    """

    resistance_n_s_per_m: NotNegative = RESISTANCE_N_S_PER_M
    mass_kg: NotNegative = 0.0
    stiffness_n_per_m: NotNegative = 0.0
    exponent: NotNegative = FORCE_EXPONENT

    def __post_init__(self) -> None:
        at_most("Fingertip.exponent", self.exponent, 2.0)

    def load(self, at_m: tuple[float, float], force_n: NotNegative = REFERENCE_FORCE_N) -> "PlateLoad":
        """The load on the plate at a place, under a force of at least 0; at 0 nothing touches.

        >>> Fingertip().load((0.1, 0.1), 0.5).resistance_n_s_per_m
        5.0
        """
        from .responses.load import PlateLoad

        # 0 ** 0 is 1: with an exponent of 0 a finger that touches nothing would load the plate
        growth = (force_n / REFERENCE_FORCE_N) ** self.exponent if force_n > 0 else 0.0
        at_2_n = self.resistance_n_s_per_m, self.mass_kg, self.stiffness_n_per_m
        return PlateLoad(*at_m, *(growth * part for part in at_2_n))
