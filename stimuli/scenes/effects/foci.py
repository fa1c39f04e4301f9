"""Several foci at the same instant."""

from dataclasses import dataclass
from math import sqrt

from tactometry.arguments.require import expect

from ...composition.content import PlateContent
from ...composition.effect import Effect, Stage, Surroundings, note
from ..stages.circuit import at_voltage

PLACES = "tactometry.stimuli.scenes.stages.emission:several"


@dataclass(frozen=True)
class Foci(Effect):
    """Additional foci at the same instant.

    Parameters
    ----------
    x_m : tuple of float
        Places of the foci along the length.
    y_m : tuple of float
        Places of the foci along the width.

    >>> Foci(x_m=(0.2,), y_m=(0.1,)).n
    2
    """

    kind = "foci"
    in_signal = True
    cures = note("add the effect foci", "peaks_m")

    x_m: tuple[float, ...]
    y_m: tuple[float, ...]

    def __post_init__(self) -> None:
        found = f"{len(self.x_m)} places but {len(self.y_m)} of y_m"
        expect(len(self.x_m) == len(self.y_m) > 0, "Foci.x_m", found, "equal numbers, at least one")

    @property
    def n(self) -> int:
        """Number of foci, including that of the surface."""
        return len(self.x_m) + 1

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        surface = scene.surface
        settings = {"x_m": (surface.focus_x_m, *self.x_m), "y_m": (surface.focus_y_m, *self.y_m)}
        return (Stage("foci", (), "foci_m", PLACES, settings), at_voltage("peaks", "per_volt_peaks", "peaks_m"))

    def in_plate(self, scene: Surroundings) -> PlateContent:
        """Return a weakening by the root of the number of foci."""
        return PlateContent(weakening=sqrt(self.n), places_m=tuple(zip(self.x_m, self.y_m, strict=True)))
