"""Dry friction of a finger that sticks and slips."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from tactometry.arguments import require
from tactometry.arguments.checked import NotNegative, checked

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
        True: the voltage adds to the friction only in full slip, as Sirin et al. (2019) found. A stuck finger then
        bears the static friction of its normal force, or the sliding friction if that is larger. False: the voltage
        also holds a stuck finger. An independent event-driven integration agrees with this setting only.
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
