"""A finger that the plate can throw off: it presses and never pulls, so that contact is lost and made again.

The skin at z answers the plate at u with f = R z' + k z, on top of the force F that presses it at rest. The contact
bears N = F + f >= 0 and z >= u, one of them with equality (Signorini's conditions): together z = u, or N = 0 and the
skin sinks back by itself, R z' + k z = -F. The plate answers f by its compliance, a convolution.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tactometry.arguments.annotations import Positive, Vector
from tactometry.arguments.checked import checked
from tactometry.errors import InvalidParameter

from ..arrays import FloatArray
from .finger import REFERENCE_FORCE_N, Fingertip
from .responses.responses import Point, impulse_responses
from .screen.screen import Screen
from .screen.transducer import PointForce


@dataclass(frozen=True, eq=False)
class ContactCourse:
    """Plate and skin at a contact that can open: (n_samples,) each.

    `contact_force_n` is the mean over the step that ends at a sample, and 0 where the two are apart.
    """

    displacement_m: FloatArray
    skin_m: FloatArray
    contact_force_n: FloatArray

    @property
    def apart(self) -> NDArray[np.bool_]:
        """Where contact is lost."""
        return np.asarray(self.contact_force_n == 0.0)


@checked
def one_sided_contact(
    screen: Screen,
    at_m: Point,
    free_m: Vector,
    rate_hz: Positive,
    f_max_hz: float,
    force_n: Positive = REFERENCE_FORCE_N,
    finger: Fingertip | None = None,
) -> ContactCourse:
    """What a finger that lifts off makes of the displacement that the free plate has at a place.

    Each step takes the force of a closed contact, or that of an open one where a closed one would pull: one of the
    two holds, never both. The midpoint rule is of second order while the state stays, of first where it changes.

    Parameters
    ----------
    free_m : (n_samples,) array
        Without the finger, from rest.
    rate_hz : float
        Of the samples, at least `f_max_hz`; events are timed to one of them, so 20 times `f_max_hz` and more.
    force_n : float
        That presses the finger, above 0.
    finger : Fingertip, optional
        Without mass: two masses that meet need a law of impact, for which there is no source here.

    Examples
    --------
    >>> from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE
    >>> sampling = {"rate_hz": 100e3, "duration_s": 2e-3, "f_max_hz": 5e3}
    >>> driven = 1e5 * impulse_responses(A4_PROTOTYPE, [(0.1, 0.1)], **sampling).samples[0, 0]
    >>> gentle, firm = (one_sided_contact(A4_PROTOTYPE, (0.1, 0.1), driven, 100e3, 5e3, f) for f in (1e-3, 20.0))
    >>> bool(gentle.apart.any()), bool(firm.apart.any())
    (True, False)
    """
    skin = (finger or Fingertip()).load(at_m, force_n)
    if skin.mass_kg > 0 or skin.resistance_n_s_per_m == 0:
        raise InvalidParameter(
            f"one_sided_contact.finger: found a mass of {skin.mass_kg} kg and a resistance of "
            f"{skin.resistance_n_s_per_m} N s/m, expected no mass and a resistance above 0"
        )
    towards_new = skin.resistance_n_s_per_m * rate_hz + skin.stiffness_n_per_m / 2
    towards_old = skin.resistance_n_s_per_m * rate_hz - skin.stiffness_n_per_m / 2
    compliance = _midpoint_compliance(screen, at_m, len(free_m), rate_hz, f_max_hz)
    return _march(free_m, compliance, force_n, towards_new, towards_old)


def _midpoint_compliance(screen: Screen, at_m: Point, n: int, rate_hz: float, f_max_hz: float) -> FloatArray:
    """(n,): the displacement (m/N) half a step, one and a half, ... after a force has begun that lasts one step."""
    alone = replace(screen, sources=(PointForce(*at_m),))
    heard = impulse_responses(alone, [at_m], rate_hz=2 * rate_hz, duration_s=n / rate_hz, f_max_hz=f_max_hz)
    return np.asarray(2 * heard.samples[0, 0, 1::2])  # a unit sample there is half of a step


def _march(
    free_m: FloatArray, compliance: FloatArray, force_n: float, towards_new: float, towards_old: float
) -> ContactCourse:
    """f = towards_new z - towards_old z_before in each step, z = u or f = -F."""
    n = len(free_m)
    plate, skin, answer = (np.zeros(n) for _ in range(3))
    plate[:1] = skin[:1] = free_m[:1]
    backwards = compliance[::-1]
    for i in range(1, n):
        # forces of the steps before, the last of them one and a half steps ago
        left = free_m[i] - backwards[n - i : n - 1] @ answer[1:i]
        together = (towards_new * left - towards_old * skin[i - 1]) / (1 + towards_new * compliance[0])
        answer[i] = max(together, -force_n)
        plate[i] = left - compliance[0] * answer[i]
        skin[i] = (answer[i] + towards_old * skin[i - 1]) / towards_new
    return ContactCourse(plate, skin, force_n + answer)
