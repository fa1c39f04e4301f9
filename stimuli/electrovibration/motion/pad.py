"""Finger pad as a mass on a spring and a damper: its constants and its motion in full slip."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import pi, sqrt
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments.annotations import NotNegative, Positive
from tactometry.arguments.checked import checked

from ...arrays import FloatArray
from ..attraction.force import ForceForm
from ..waveforms.pieces import Pieces
from .coulomb_friction import CoulombFriction
from .driven_motion import LinearSystem, Timing, plan_of, stack_heights

MASS_KG_PER_M_PER_S: Final = 3.23e-2
STIFFNESS_N_S_PER_M2: Final = 4_040.0
DAMPING_N_S_PER_M: Final = 1.5
"""Of the skin of a fingertip in tangential direction, as in `SkinMobility`: an unverified default, whose order of
magnitude is from memory of Wiertlewski and Hayward (2012). Mass and stiffness per speed are from Balasubramanian, Pool
and Vardar (2025), whose abstract, which is what we have, says no damping."""


@checked
@dataclass(frozen=True)
class Finger:
    """``m x'' + c x' + k x = f``: x the skin's deflection (m) under a lateral force f.

    The defaults are unverified: a speed of 50 mm/s in `at_speed`.

    >>> round(Finger().natural_frequency_hz, 2), round(Finger().damping_ratio, 2)
    (56.29, 1.31)
    """

    mass_kg: Positive = 1.615e-3
    stiffness_n_per_m: Positive = 202.0
    damping_n_s_per_m: NotNegative = DAMPING_N_S_PER_M

    @classmethod
    def at_speed(cls, speed_m_per_s: Positive, damping_n_s_per_m: NotNegative = DAMPING_N_S_PER_M) -> "Finger":
        """The moving mass and stiffness that are published per sliding speed, 20 to 100 mm/s.

        Mass 3.23e-5 kg and stiffness 4.04 N/m per mm/s. The damping is the same at all speeds, an unverified default:
        3.3 times the critical at 20 mm/s, 0.66 times at 100 mm/s.

        >>> slow, fast = Finger.at_speed(0.02), Finger.at_speed(0.1)
        >>> round((fast.mass_kg - slow.mass_kg) * 1e3, 3), round(fast.stiffness_n_per_m - slow.stiffness_n_per_m, 1)
        (2.584, 323.2)
        """
        return cls(MASS_KG_PER_M_PER_S * speed_m_per_s, STIFFNESS_N_S_PER_M2 * speed_m_per_s, damping_n_s_per_m)

    @property
    def natural_frequency_hz(self) -> float:
        return float(sqrt(self.stiffness_n_per_m / self.mass_kg) / (2 * pi))

    @property
    def damping_ratio(self) -> float:
        """The damping over the critical one: from 1 on the pad does not ring."""
        return float(self.damping_n_s_per_m / (2 * sqrt(self.stiffness_n_per_m * self.mass_kg)))

    @cached_property
    def system(self) -> LinearSystem:
        """States (x, x') under a force in newton."""
        m, k, c = self.mass_kg, self.stiffness_n_per_m, self.damping_n_s_per_m
        return LinearSystem(((0.0, 1.0), (-k / m, -c / m)), (0.0, 1 / m))


@dataclass(frozen=True, eq=False)
class Motion:
    """A finger over time, arrays (..., n_times): lateral force on the skin (N), deflection (m), and its derivatives."""

    t_s: FloatArray
    electrostatic_n: FloatArray
    lateral_n: FloatArray
    deflection_m: FloatArray
    speed_m_per_s: FloatArray
    acceleration_m_per_s2: FloatArray


@checked
def sliding(
    t_s: ArrayLike,
    pieces: Pieces,
    form: ForceForm,
    *,
    finger: Finger,
    friction: CoulombFriction,
    force_n: float,
) -> Motion:
    """Motion of a finger in full slip under a normal force (N), from its rest under constant friction: exact.

    The lateral force is ``mu (F_n + F_e)``. There is no slip-rate in it, so that any speed gives the same; whether the
    finger slips at all is the matter of `stick_slip`.

    Parameters
    ----------
    t_s : (n_times,) array
        Ascending from at least 0 to at most the end of the voltage.

    Raises
    ------
    InvalidParameter
        If the times are not as stated or the force is negative.
    """
    t = np.asarray(t_s, dtype=np.float64)
    return Motion(t, *_rows(t, (pieces,), form, finger, friction, force_n)[0])


@checked
def sliding_many(
    t_s: ArrayLike,
    stimuli: Sequence[Pieces],
    form: ForceForm,
    *,
    finger: Finger,
    friction: CoulombFriction,
    force_n: float,
) -> Motion:
    """`sliding` for many voltages whose pieces start at the same times: arrays (n_stimuli, n_times).

    All share the exponentials of one plan: what differs is heights, slopes and phases.

    Raises
    ------
    InvalidParameter
        As in `sliding`, and if the pieces of a stimulus do not start when those of the first one do.
    """
    t = np.asarray(t_s, dtype=np.float64)
    return Motion(t, *_rows(t, stimuli, form, finger, friction, force_n).swapaxes(0, 1))


def _rows(
    t_s: FloatArray,
    stimuli: Sequence[Pieces],
    form: ForceForm,
    finger: Finger,
    friction: CoulombFriction,
    force_n: float,
) -> FloatArray:
    """Rows of `Motion` below the times, (n_stimuli, 5, n_times)."""
    from .compiled_loops import FullSlip, slide

    pad = finger.mass_kg, finger.damping_n_s_per_m, finger.stiffness_n_per_m
    pressed = FullSlip(*pad, friction.coefficient_at(force_n), force_n)
    voltages = stack_heights(stimuli)
    timing = Timing(stimuli[0], t_s, has_slope=bool(voltages.slopes.any()))
    plan = plan_of(timing, form.relaxations, finger.system)
    return slide(form.newton_per_v2, pressed, voltages, plan)
