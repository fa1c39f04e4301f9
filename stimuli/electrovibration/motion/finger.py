"""Exact motion of a finger pad that slides under an electrostatic force."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments.checked import checked

from ...arrays import FloatArray
from ..attraction.force import ForceForm
from ..waveforms.pieces import Pieces
from .coulomb_friction import CoulombFriction
from .driven_motion import Timing, plan_of
from .pad import Finger
from .phases import heights


@dataclass(frozen=True, eq=False)
class Motion:
    """Motion of a finger as arrays (..., n_times): lateral force (N), skin deflection (m), derivatives."""

    t_s: FloatArray
    electrostatic_n: FloatArray
    lateral_n: FloatArray
    deflection_m: FloatArray
    speed_m_per_s: FloatArray
    acceleration_m_per_s2: FloatArray


@checked
def sliding(
    t_s: ArrayLike, pieces: Pieces, form: ForceForm, *, finger: Finger, friction: CoulombFriction, force_n: float
) -> Motion:
    """Return the exact motion in full slip from rest, constant friction.

    The lateral force is ``mu (F_n + F_e)``. It does not depend on the speed of slip. `stick_slip` computes whether the
    finger slips at all.

    Raises `InvalidParameter` if the times do not ascend within the voltage or the force is negative.

    Parameters
    ----------
    t_s : (n_times,) array
        Ascending from at least 0 to at most the end of the voltage.
    """
    from .compiled_loops import FullSlip, slide

    t = np.asarray(t_s, dtype=np.float64)
    pad = finger.mass_kg, finger.damping_n_s_per_m, finger.stiffness_n_per_m
    pressed = FullSlip(*pad, friction.coefficient_at(force_n), force_n)
    plan = plan_of(Timing(pieces, t), form.relaxations, finger.system)
    return Motion(t, *slide(form.newton_per_v2, pressed, heights(pieces), plan))
