"""The moving skin of a finger pad as mass, spring and damper; what is published of it per speed, 20 to 100 mm/s."""

from dataclasses import dataclass
from functools import cached_property
from math import pi, sqrt
from typing import Final

from tactometry.arguments.annotations import NotNegative, Positive
from tactometry.arguments.checked import checked

from .driven_flow import LinearSystem

MASS_KG_PER_M_PER_S: Final = 3.23e-2
STIFFNESS_N_S_PER_M2: Final = 4_040.0
CUTOFF_HZ_S_PER_M: Final = 13_800.0


@checked
@dataclass(frozen=True)
class Finger:
    """``m x'' + c x' + k x = f``: x the skin's deflection (m) under a lateral force f.

    The defaults are unverified: a speed of 50 mm/s in `at_speed`.

    >>> round(Finger().natural_frequency_hz, 2)
    56.29
    """

    mass_kg: Positive = 1.615e-3
    stiffness_n_per_m: Positive = 202.0
    damping_n_s_per_m: NotNegative = 0.0466

    @classmethod
    def at_speed(cls, speed_m_per_s: Positive) -> "Finger":
        """The moving mass and stiffness that are published per sliding speed, 20 to 100 mm/s.

        Mass 3.23e-5 kg and stiffness 4.04 N/m per mm/s. The damping is an unverified choice: it puts
        ``k/(2 pi c)`` at the published cut-off of 13.8 Hz per mm/s.

        >>> slow, fast = Finger.at_speed(0.02), Finger.at_speed(0.1)
        >>> round((fast.mass_kg - slow.mass_kg) * 1e3, 3), round(fast.stiffness_n_per_m - slow.stiffness_n_per_m, 1)
        (2.584, 323.2)
        """
        stiffness = STIFFNESS_N_S_PER_M2 * speed_m_per_s
        damping = STIFFNESS_N_S_PER_M2 / (2 * pi * CUTOFF_HZ_S_PER_M)
        return cls(MASS_KG_PER_M_PER_S * speed_m_per_s, stiffness, damping)

    @property
    def natural_frequency_hz(self) -> float:
        return float(sqrt(self.stiffness_n_per_m / self.mass_kg) / (2 * pi))

    @cached_property
    def system(self) -> LinearSystem:
        """States (x, x') under a force in newton."""
        m, k, c = self.mass_kg, self.stiffness_n_per_m, self.damping_n_s_per_m
        return LinearSystem(((0.0, 1.0), (-k / m, -c / m)), (0.0, 1 / m))
