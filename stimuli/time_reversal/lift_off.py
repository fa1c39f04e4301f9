"""Fingers that the plate can throw off: they press and never pull.

The skin at z exerts the force f = R z' + k z on the plate at u, in addition to the normal force F. The contact force is
N = F + f >= 0, and z >= u; one of the two is an equality (Signorini's conditions). In contact z = u. Without contact N
= 0, and the skin relaxes by itself: R z' + k z = -F. The plate responds to f by its compliance, a convolution.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tactometry.arguments.checked import Positive, Vector, checked
from tactometry.arguments.require import expect, positive, shape

from ..arrays import FloatArray
from ..defaults import REFERENCE_FORCE_N
from .fingertip import Fingertip
from .responses.load import PlateLoad
from .responses.responses import Point, impulse_responses
from .screen.screen import Screen
from .screen.transducer import PointForce

PASSES: Final = 4
"""Iterations over contacts coupled within a step; each reduces the error at least fiftyfold."""


@dataclass(frozen=True, eq=False)
class ContactCourse:
    """Motion of plate and skin at a contact that can open, (n_samples,) each.

    `contact_force_n` is the mean over the step that ends at a sample, and 0 where contact is lost.
    """

    displacement_m: FloatArray
    skin_m: FloatArray
    contact_force_n: FloatArray

    @property
    def apart(self) -> NDArray[np.bool_]:
        """True for each sample at which contact is lost."""
        return np.asarray(self.contact_force_n == 0.0)


@dataclass(frozen=True, eq=False)
class ContactCourses(ContactCourse):
    """Courses of several contacts on one plate, (n_contacts, n_samples), with normal forces `force_n` (n_contacts,)."""

    force_n: FloatArray


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
    """Return the course of a contact that can open, from free motion.

    Each step uses the force of a closed contact, or of an open contact if a closed one would pull. The midpoint rule is
    of second order, and of first order where the contact opens or closes.

    Parameters
    ----------
    free_m : (n_samples,) array
        Displacement of the plate without the finger, from rest.
    rate_hz : float
        Sampling rate, at least `f_max_hz`. Events are timed to one sample, so use 20 times `f_max_hz` or more.
    force_n : float
        Normal force of the finger, above 0.
    finger : Fingertip, optional
        Finger without mass, since an impact of two masses needs a law for which we have no source.

    >>> from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE
    >>> sampling = {"rate_hz": 100e3, "duration_s": 2e-3, "f_max_hz": 5e3}
    >>> driven = 1e5 * impulse_responses(A4_PROTOTYPE, [(0.1, 0.1)], **sampling).samples[0, 0]
    >>> gentle, firm = (one_sided_contact(A4_PROTOTYPE, (0.1, 0.1), driven, 100e3, 5e3, f) for f in (1e-3, 20.0))
    >>> bool(gentle.apart.any()), bool(firm.apart.any())
    (True, False)
    """
    skin = (finger or Fingertip()).load(at_m, force_n)
    both = one_sided_contacts(screen, free_m[None], [skin], np.array([force_n]), rate_hz, f_max_hz)
    return ContactCourse(both.displacement_m[0], both.skin_m[0], both.contact_force_n[0])


@checked
def one_sided_contacts(
    screen: Screen,
    free_m: FloatArray,
    loads: Sequence[PlateLoad],
    force_n: Vector,
    rate_hz: Positive,
    f_max_hz: float,
    still_m_per_n: FloatArray | None = None,
) -> ContactCourses:
    """Return the courses of contacts that can open, from free motion.

    Like `one_sided_contact`, for displacements (n_contacts, n_samples) of the free plate. The force of each contact
    moves the plate under all contacts.

    Raises `InvalidParameter` if a finger has a mass, or no resistance.

    Parameters
    ----------
    still_m_per_n : (n_contacts, n_contacts) array, optional
        Static compliance of the modes above `f_max_hz`; by default none.
    """
    shape("one_sided_contacts.free_m", free_m, (len(loads), None))
    shape("one_sided_contacts.force_n", force_n, (len(loads),))
    positive("one_sided_contacts", force_n=float(force_n.min(initial=1.0)))
    for skin in loads:
        found = f"a mass of {skin.mass_kg} kg and a resistance of {skin.resistance_n_s_per_m} N s/m"
        expected = "no mass and a resistance above 0"
        expect(skin.mass_kg == 0 and skin.resistance_n_s_per_m != 0, "one_sided_contact.finger", found, expected)
    places = [(skin.x_m, skin.y_m) for skin in loads]
    alone = replace(screen, sources=tuple(PointForce(*place) for place in places))
    long_s = free_m.shape[1] / rate_hz
    responses = impulse_responses(alone, places, rate_hz=2 * rate_hz, duration_s=long_s, f_max_hz=f_max_hz)

    # compliance (m/N) at 0.5, 1.5, ... steps after the start of a force that lasts one step
    compliance = np.asarray(2 * responses.samples[..., 1::2])
    compliance[:, :, 0] += 0.0 if still_m_per_n is None else still_m_per_n
    damping = rate_hz * np.array([skin.resistance_n_s_per_m for skin in loads])
    spring = np.array([skin.stiffness_n_per_m for skin in loads]) / 2
    return _march(free_m, compliance, force_n, damping + spring, damping - spring)


def _march(
    free_m: FloatArray, compliance: FloatArray, force_n: FloatArray, towards_new: FloatArray, towards_old: FloatArray
) -> ContactCourses:
    """Solve f = towards_new z - towards_old z_before per step, z = u or f = -F."""
    k, n = free_m.shape
    plate, skin, answer = (np.zeros((k, n)) for _ in range(3))
    plate[:, :1] = skin[:, :1] = free_m[:, :1]
    backwards, now = np.ascontiguousarray(compliance[:, :, ::-1]), compliance[:, :, 0]
    own, others = now.diagonal(), now - np.diag(now.diagonal())
    for i in range(1, n):
        # forces of earlier steps, the latest 1.5 steps ago
        left = free_m[:, i] - np.einsum("abj,bj->a", backwards[:, :, n - i : n - 1], answer[:, 1:i])
        for _ in range(PASSES if k > 1 else 1):
            alone = left - others @ answer[:, i]
            together = (towards_new * alone - towards_old * skin[:, i - 1]) / (1 + towards_new * own)
            answer[:, i] = np.maximum(together, -force_n)
        plate[:, i] = left - now @ answer[:, i]
        skin[:, i] = (answer[:, i] + towards_old * skin[:, i - 1]) / towards_new
    return ContactCourses(plate, skin, force_n[:, None] + answer, force_n)
