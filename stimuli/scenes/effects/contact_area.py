"""The contact area grows with the force that presses the finger."""

from collections.abc import Callable
from dataclasses import dataclass

from tactometry.arguments import require

from ...composition.effect import Effect, Stage, Surroundings


@dataclass(frozen=True)
class ContactArea(Effect):
    """``A = A_1 (F/1 N)^exponent``; both defaults are unverified.

    >>> ContactArea().area_at_1n_m2
    0.0001
    """

    kind = "contact_area"
    slot = "area"
    requires = ("contact",)
    assumes = ("the area is a power of the force, and no other after a time",)

    area_at_1n_m2: float = 1e-4
    exponent: float = 1 / 3

    def __post_init__(self) -> None:
        require.positive("ContactArea", area_at_1n_m2=self.area_at_1n_m2)
        require.not_negative("ContactArea", exponent=self.exponent)

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        settings = {
            "area_at_1n_m2": self.area_at_1n_m2,
            "exponent": self.exponent,
            "force_n": scene.contacts[0].force_n,
        }
        return (Stage("contact_area", (), "area_m2", f"{__name__}:pressed", settings),)


def pressed(area_at_1n_m2: float, exponent: float, force_n: float) -> Callable[[], float]:
    """The area under a force."""
    from ...electrovibration.attraction.contact_area import PowerLawArea

    area_m2 = float(PowerLawArea(area_at_1n_m2, exponent).area_m2(force_n))
    return lambda: area_m2
