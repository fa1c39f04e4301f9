"""Several foci at the same instant."""

from collections.abc import Callable
from dataclasses import dataclass
from math import sqrt
from typing import TYPE_CHECKING, Any

from tactometry.errors import InvalidParameter

from ...composition.effect import Effect, Stage, Surroundings

if TYPE_CHECKING:
    from ...arrays import FloatArray
    from ..stages.emission import Points


@dataclass(frozen=True)
class Foci(Effect):
    """Further places to focus on at the same instant, beside the one of the surface.

    >>> Foci(x_m=(0.2,), y_m=(0.1,)).n
    2
    """

    kind = "foci"
    slot = "foci"

    x_m: tuple[float, ...]
    y_m: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.x_m) != len(self.y_m) or not self.x_m:
            raise InvalidParameter(
                f"Foci.x_m: found {len(self.x_m)} places beside {len(self.y_m)} of y_m, expected as many, at least one"
            )

    @property
    def n(self) -> int:
        """How many foci there are with that of the surface."""
        return len(self.x_m) + 1

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        surface: Any = scene.surface
        settings = {"x_m": (surface.focus_x_m, *self.x_m), "y_m": (surface.focus_y_m, *self.y_m)}
        return (
            Stage("foci", (), "foci_m", f"{__name__}:several", settings),
            Stage("peaks", ("per_volt_peaks", "voltage_v"), "peaks_m", f"{__name__}:each"),
        )

    def weakening(self, scene: Surroundings) -> float:
        """Each focus keeps one over the root of their number."""
        del scene
        return sqrt(self.n)


def several(x_m: tuple[float, ...], y_m: tuple[float, ...]) -> "Callable[[], Points]":
    """Places to focus on."""
    places = tuple(zip(x_m, y_m, strict=True))
    return lambda: places


def each() -> "Callable[[FloatArray, float], FloatArray]":
    """The displacement of every focus at a voltage."""
    return lambda values, voltage_v: values * voltage_v
