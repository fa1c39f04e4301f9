"""Coulomb friction of a finger that slides all the time."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from tactometry.arguments import require

from ...composition.effect import Effect, Stage, Surroundings

if TYPE_CHECKING:
    from ...arrays import FloatArray
    from ...electrovibration.motion.friction import CoulombFriction


@dataclass(frozen=True)
class Friction(Effect):
    """``F = mu (F_n + F_e)`` with ``mu = coefficient (F_n/1 N)^load_exponent``; 0.5 is an unverified default.

    >>> Friction(0.4).slot
    'friction'
    """

    kind = "friction"
    slot = "friction"
    requires = ("sliding contact",)
    cures: ClassVar[Mapping[str, str]] = {
        "friction_force_n": "add the effect friction, or dry_friction with finger_dynamics, and a sliding contact"
    }
    assumes = ("the finger slides all the time; its coefficient knows no speed",)

    coefficient: float = 0.5
    load_exponent: float = 0.0

    def __post_init__(self) -> None:
        require.not_negative("Friction", coefficient=self.coefficient)

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        law = {"coefficient": self.coefficient, "load_exponent": self.load_exponent}
        settings = {**law, "force_n": scene.contacts[0].force_n}
        return (
            Stage("friction_law", (), "friction_law", f"{__name__}:law", law),
            Stage("friction", ("electrostatic_force_n",), "friction_force_n", f"{__name__}:dragged", settings),
        )


def law(coefficient: float, load_exponent: float) -> "Callable[[], CoulombFriction]":
    """The law as the exact motions take it."""
    from ...electrovibration.motion.friction import CoulombFriction

    coulomb = CoulombFriction(coefficient, load_exponent)
    return lambda: coulomb


def dragged(coefficient: float, load_exponent: float, force_n: float) -> "Callable[[FloatArray], FloatArray]":
    """Friction under a normal force and an attraction."""
    mu = law(coefficient, load_exponent)().coefficient_at(force_n)
    return lambda electrostatic_n: mu * (force_n + electrostatic_n)
