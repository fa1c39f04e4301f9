"""Mobility of the skin under a vibrating lateral force."""

from dataclasses import dataclass, replace
from math import pi
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments import require
from tactometry.contact import Contact
from tactometry.errors import InvalidParameter

from ...arrays import FloatArray
from ...composition.content import VoltageContent
from ...composition.effect import Effect, Surroundings, note

if TYPE_CHECKING:
    from ...perception.detection import Components


@dataclass(frozen=True)
class SkinMobility(Effect):
    """Skin displacement over lateral force, ``1/(k - m w^2 + i w c)``.

    Stiffness, damping and moving mass in tangential direction are from memory: orders of magnitude of Wiertlewski and
    Hayward (J. Biomech. 45, 1869, 2012), who found the fingertip elastic below some 100 Hz and viscous above. By
    default the stiffness does not grow with the normal force. Sources: `skin_mobility` in `stimuli/sources.toml`.

    Parameters
    ----------
    stiffness_n_per_m : float
        Stiffness of the skin under a normal force of 1 N, above 0.
    damping_n_s_per_m : float
        Damping of the skin under a normal force of 1 N, above 0.
    mass_kg : float
        Moving mass of the skin under a normal force of 1 N, at least 0.
    stiffness_exponent : float
        Exponent by which the stiffness grows with the normal force, at least 0.
    damping_exponent : float
        Exponent by which the damping grows with the normal force, at least 0.

    >>> skin = SkinMobility()
    >>> [round(1e-7 / float(skin.gain_m_per_n(f, force_n=1.0)), 6) for f in (60.0, 250.0)]  # N, of 0.1 um
    [0.000113, 0.000244]
    """

    kind = "skin_mobility"
    slot = "mobility"
    positive = ("stiffness_n_per_m", "damping_n_s_per_m")
    not_negative = ("mass_kg", "stiffness_exponent", "damping_exponent")
    requires = ("friction", "sliding contact")
    reads, gives = ("components", "contact"), "skin_components"
    stage_name = "skin_motion"
    excludes = note("it moves the skin by itself; remove 'skin_mobility' or 'finger_dynamics'", "finger_dynamics")
    assumes = ("the pulp is one mass, spring and damper that neither speed nor amplitude changes",)

    stiffness_n_per_m: float = 1000.0
    damping_n_s_per_m: float = 1.5
    mass_kg: float = 0.15e-3
    stiffness_exponent: float = 0.0
    damping_exponent: float = 0.0

    def under(self, force_n: float) -> Self:
        """Return the mobility of the skin under a constant normal force (above 0).

        >>> SkinMobility(damping_exponent=0.5).under(4.0).damping_n_s_per_m
        3.0
        """
        if self.stiffness_exponent == self.damping_exponent == 0:
            return self
        require.positive("SkinMobility.under", force_n=force_n)
        stiffness_n_per_m = self.stiffness_n_per_m * _grown(force_n, self.stiffness_exponent)
        damping_n_s_per_m = self.damping_n_s_per_m * _grown(force_n, self.damping_exponent)
        grown = {"stiffness_n_per_m": stiffness_n_per_m, "damping_n_s_per_m": damping_n_s_per_m}
        return replace(self, **grown, stiffness_exponent=0.0, damping_exponent=0.0)

    def gain_m_per_n(self, frequency_hz: ArrayLike, force_n: float) -> FloatArray:
        """Return displacement per newton at frequencies (Hz) under a load (N).

        Raises `InvalidParameter` if the force is not above 0, or a frequency is below it.
        """
        require.positive("SkinMobility.gain_m_per_n", force_n=force_n)
        frequencies_hz = require.not_negative_array("SkinMobility.gain_m_per_n.frequency_hz", frequency_hz)
        return self._gain_m_per_n(frequencies_hz, force_n)

    def _gain_m_per_n(self, frequencies_hz: FloatArray, force_n: float) -> FloatArray:
        skin, omega = self.under(force_n), 2 * pi * frequencies_hz
        elastic = skin.stiffness_n_per_m - skin.mass_kg * omega * omega
        return np.asarray(1 / np.hypot(elastic, skin.damping_n_s_per_m * omega))

    def __call__(self, components: "Components", contact: Contact) -> "Components":
        """Components of the skin (m) by those of friction (N)."""
        return components.times(self._gain_m_per_n(components.frequencies_hz, contact.force_n))

    def in_voltage(self, scene: Surroundings) -> VoltageContent:
        """Return the steepest slope: each pole adds at most 1 over its distance."""
        skin = self.under(scene.contacts[0].force_n)
        poles = np.roots([skin.mass_kg, skin.damping_n_s_per_m, skin.stiffness_n_per_m])
        return VoltageContent(steepest_db_per_hz=float(40 * pi / np.log(10) * np.sum(1 / -poles.real)))


def _grown(force_n: float, exponent: float) -> float:
    try:
        return float(float(force_n) ** exponent)
    except OverflowError:
        raise InvalidParameter(
            f"SkinMobility: found an exponent of {exponent} for a normal force of {force_n} N, expected a power within "
            "the range of a double"
        ) from None
