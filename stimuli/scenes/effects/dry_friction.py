"""Dry friction with a static and a kinetic coefficient: a finger that sticks and slips."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from tactometry.arguments import require
from tactometry.errors import InvalidParameter

from ...composition.effect import Effect, Stage, Surroundings

if TYPE_CHECKING:
    from ...electrovibration.motion.stick_slip import DryFriction as Law


@dataclass(frozen=True)
class DryFriction(Effect):
    """Coefficients, static at least kinetic; both defaults are unverified. The motion itself is `finger_dynamics`.

    >>> DryFriction().static
    0.6
    """

    kind = "dry_friction"
    slot = "friction"
    requires = ("sliding contact", "dynamics")
    excludes: ClassVar[Mapping[str, str]] = {
        "friction_lag": "a lag has no stick; use 'friction' with it, or 'finger_dynamics' in its place"
    }
    assumes = ("the coefficients know neither load nor speed nor time of rest",)

    static: float = 0.6
    kinetic: float = 0.5

    def __post_init__(self) -> None:
        require.not_negative("DryFriction", kinetic=self.kinetic, static=self.static)
        if self.static < self.kinetic:
            raise InvalidParameter(
                f"DryFriction.static: found {self.static}, expected at least the kinetic coefficient ({self.kinetic})"
            )

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        del scene
        settings = {"static": self.static, "kinetic": self.kinetic}
        return (Stage("friction_law", (), "friction_law", f"{__name__}:law", settings),)


def law(static: float, kinetic: float) -> "Callable[[], Law]":
    """The law as the event-exact motion takes it."""
    from ...electrovibration.motion.stick_slip import DryFriction as Dry

    dry = Dry(static, kinetic)
    return lambda: dry
