"""Coulomb friction of a finger that slides all the time."""

from dataclasses import dataclass, replace
from math import hypot
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments import require
from tactometry.arguments.checked import checked
from tactometry.contact import Contact
from tactometry.errors import InvalidParameter

from ...arrays import FloatArray
from ...composition.effect import Effect, Stage, Surroundings, is_changed, note

if TYPE_CHECKING:
    from ...perception.detection import Components


@dataclass(frozen=True)
class CoulombFriction(Effect):
    """``F_f = mu (F_n + F_e)`` with ``mu = mu_1 (F_n/1 N)^exponent``.

    A coefficient of 0.5 at 1 N is within published ranges (`friction` in `stimuli/sources.toml`). With an exponent
    below 0 it falls with load. The load F_n is that of the finger: the voltage does not change the coefficient.

    An exponent of 0 is Coulomb's law, as Dzidek et al. (J. R. Soc. Interface 14, 20160935, 2017, abstract) report for a
    finger pad, except after more than 10 s on smooth glass, where the coefficient falls by a factor of five over their
    loads. A smooth Hertz contact whose friction is proportional to its area has -1/3 (textbook). From 1 to 20 N a
    coefficient fell by 46 % on average, an exponent of -0.21 (Seo, Armstrong and Drinkaus, Ergonomics 52, 609, 2009,
    abstract; aluminium and rubber).

    At a speed v it is the regularised law, ``mu v/sqrt(v^2 + v_s^2)``: a finger far below `slip_speed_m_per_s` creeps
    and hardly slips, so that sensation goes smoothly to nothing at rest; 1 mm/s is a choice.

    Parameters
    ----------
    coefficient : float
        Of friction at 1 N.
    load_exponent : float
        Exponent by which it changes with the load, the load index less 1: below 0 it falls.
    slip_speed_m_per_s : float
        Below this speed the finger creeps.

    >>> float(CoulombFriction(0.5).modulation_n(0.01, force_n=1.0))
    0.005
    """

    kind = "friction"
    requires = ("sliding contact",)
    reads = ("contact",)
    gives = stage_name = "friction_law"
    assumes = ("the finger slides all the time; its coefficient knows no speed far above slip_speed_m_per_s",)
    cures = note(
        "add the effect friction, or dry_friction with finger_dynamics, and a sliding contact", "friction_force_n"
    )

    coefficient: float = 0.5
    load_exponent: float = 0.0
    slip_speed_m_per_s: float = 1e-3

    def __post_init__(self) -> None:
        require.positive("CoulombFriction", slip_speed_m_per_s=self.slip_speed_m_per_s)
        require.not_negative("CoulombFriction", coefficient=self.coefficient)
        require.finite("CoulombFriction", load_exponent=self.load_exponent)

    def at_speed(self, speed_m_per_s: float) -> Self:
        """Return the friction law of a finger that slides at a speed (at least 0).

        >>> [round(CoulombFriction(0.5).at_speed(speed).coefficient, 4) for speed in (0.0, 1e-3, 0.05)]
        [0.0, 0.3536, 0.4999]
        """
        require.not_negative("CoulombFriction", speed_m_per_s=speed_m_per_s)
        share = speed_m_per_s / hypot(speed_m_per_s, self.slip_speed_m_per_s)
        return replace(self, coefficient=share * self.coefficient)

    def coefficient_at(self, force_n: float) -> float:
        """Return the coefficient under a normal force (N).

        Without one it is the constant coefficient (the voltage alone causes friction, ``mu F_e``), 0 for an exponent
        above 0, and without a limit for an exponent below 0, which is refused.

        >>> CoulombFriction(0.5).coefficient_at(0.0), CoulombFriction(0.5, load_exponent=0.1).coefficient_at(0.0)
        (0.5, 0.0)
        """
        require.not_negative("CoulombFriction", force_n=force_n)
        try:
            return float(self.coefficient * float(force_n) ** self.load_exponent)
        except (OverflowError, ZeroDivisionError):
            raise InvalidParameter(
                f"CoulombFriction.load_exponent: found {self.load_exponent} for a normal force of {force_n} N, "
                "expected a coefficient within the range of a double"
            ) from None

    @checked
    def modulation_n(self, electrostatic_n: ArrayLike, force_n: float) -> FloatArray:
        """Return the change of friction, ``mu F_e``, by an attraction."""
        with np.errstate(over="ignore"):
            change_n = self.coefficient_at(force_n) * np.asarray(electrostatic_n, dtype=np.float64)
        return require.in_range("CoulombFriction.modulation_n", change_n)

    def __call__(self, contact: Contact) -> Self:
        return self.at_speed(contact.speed_m_per_s)

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        needs = ("electrostatic_force_n", "friction_law", "contact")
        return self.stage(), Stage("friction", needs, "friction_force_n", f"{__name__}:friction_n")

    def felt_stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        """Return stages that scale components, or the course if effects change it."""
        if is_changed("friction_force_n", scene):
            return self.stages(scene)
        needs = ("attraction_components", "friction_law", "contact")
        return self.stage(), Stage("friction", needs, "components", f"{__name__}:friction_components")


def friction_n(electrostatic_n: FloatArray, law: CoulombFriction, contact: Contact) -> FloatArray:
    """Friction under a normal force and an attraction."""
    return law.coefficient_at(contact.force_n) * (contact.force_n + electrostatic_n)


def friction_components(parts: "Components", law: CoulombFriction, contact: Contact) -> "Components":
    """Components of the friction that those of an attraction cause."""
    return parts.times(law.coefficient_at(contact.force_n))
