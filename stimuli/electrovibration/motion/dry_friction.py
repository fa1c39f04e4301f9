"""Dry friction of a finger that sticks and slips."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from tactometry.arguments import require
from tactometry.arguments.annotations import NotNegative
from tactometry.arguments.checked import checked

from ...composition.effect import Quantity


@checked
@dataclass(frozen=True)
class DryFriction(Quantity):
    """Coulomb friction with a static and a kinetic coefficient; both defaults are unverified.

    If the static coefficient is the larger one, a friction law that is smooth in the speed does not approximate this
    model: its peak stays below the static friction at any width.

    Parameters
    ----------
    static : float
        Coefficient of friction of a finger that sticks, at least `kinetic`.
    kinetic : float
        Coefficient of friction of a finger that slides.
    gated : bool
        The voltage adds to the friction in full slip alone, as Sirin et al. (2019) found: a stuck finger bears its
        normal force's static friction (or the slipping one, if that is more). Without, it holds a stuck finger too, as
        in an independent event-driven integration, which agrees with this alone.
    """

    kind = "dry_friction"
    slot = "friction"
    requires = ("sliding contact", "dynamics")
    excludes: ClassVar[Mapping[str, str]] = {
        "friction_lag": "a lag has no stick; use 'friction' with the lag, or 'finger_dynamics' instead of it"
    }
    gives = stage_name = "friction_law"
    assumes = ("the coefficients depend neither on load nor on speed nor on time at rest",)

    static: NotNegative = 0.6
    kinetic: NotNegative = 0.5
    gated: bool = True

    def __post_init__(self) -> None:
        least = f"at least the kinetic coefficient ({self.kinetic})"
        require.expect(self.static >= self.kinetic, "DryFriction.static", self.static, least)
