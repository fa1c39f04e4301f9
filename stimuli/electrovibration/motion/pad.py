"""Mass, spring and damper of the moving skin of a finger pad."""

from dataclasses import dataclass
from functools import cached_property
from typing import Final

from tactometry.arguments.checked import NotNegative, Positive, checked

from .driven_motion import LinearSystem

MASS_KG_PER_M_PER_S: Final = 3.23e-2
STIFFNESS_N_S_PER_M2: Final = 4_040.0
DAMPING_N_S_PER_M: Final = 1.5
"""Tangential damping of the skin of a fingertip, as in `SkinMobility`: an unverified default, its order of magnitude
from memory of Wiertlewski and Hayward (2012). Mass and stiffness per speed are from the abstract of Balasubramanian,
Pool and Vardar (2025), which states no damping."""


@checked
@dataclass(frozen=True)
class Finger:
    """A finger pad, ``m x'' + c x' + k x = f``, with deflection x (m) of the skin under a lateral force f.

    The unverified defaults are the values of `at_speed` at 50 mm/s. They do not depend on the normal force. For a pad
    under a force, use stiffness and damping of `SkinMobility.under`; `sliding` and `stick_slip` do not do so.
    """

    mass_kg: Positive = 1.615e-3
    stiffness_n_per_m: Positive = 202.0
    damping_n_s_per_m: NotNegative = DAMPING_N_S_PER_M

    @classmethod
    def at_speed(cls, speed_m_per_s: Positive, damping_n_s_per_m: NotNegative = DAMPING_N_S_PER_M) -> "Finger":
        """Return the pad with the mass and stiffness published for 20 to 100 mm/s.

        Mass 3.23e-5 kg and stiffness 4.04 N/m per mm/s. The damping is the same at all speeds (unverified default): 3.3
        times the critical damping at 20 mm/s, 0.66 times at 100 mm/s.

        >>> slow, fast = Finger.at_speed(0.02), Finger.at_speed(0.1)
        >>> round((fast.mass_kg - slow.mass_kg) * 1e3, 3), round(fast.stiffness_n_per_m - slow.stiffness_n_per_m, 1)
        (2.584, 323.2)
        """
        return cls(MASS_KG_PER_M_PER_S * speed_m_per_s, STIFFNESS_N_S_PER_M2 * speed_m_per_s, damping_n_s_per_m)

    @cached_property
    def system(self) -> LinearSystem:
        """The linear system of (x, x') driven by a force in newton."""
        m, k, c = self.mass_kg, self.stiffness_n_per_m, self.damping_n_s_per_m
        return LinearSystem(((0.0, 1.0), (-k / m, -c / m)), (0.0, 1 / m))
