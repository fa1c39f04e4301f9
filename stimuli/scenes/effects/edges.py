"""Edges other than simply supported: modes by Rayleigh and Ritz."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

from tactometry.errors import InvalidParameter
from tactometry.stimuli.scenes.effect import Budget, Surroundings
from tactometry.stimuli.scenes.stage import Stage

if TYPE_CHECKING:
    from tactometry.stimuli.time_reversal.plate import Plate


@dataclass(frozen=True)
class Edges:
    """Four letters of S, C, F for the edges x = 0, y = 0, x = length, y = width, other than ``SSSS``.

    >>> Edges("FFFF").slot
    'edges'
    """

    kind: ClassVar[str] = "edges"
    slot: ClassVar[str] = "edges"
    requires: ClassVar[tuple[str, ...]] = ()
    excludes: ClassVar[Mapping[str, str]] = {}

    boundary: str

    def __post_init__(self) -> None:
        if len(self.boundary) != 4 or not set(self.boundary) <= set("SCF"):
            raise InvalidParameter(
                f"Edges.boundary: found {self.boundary!r}, expected four letters of S, C, F, such as 'FFFF'"
            )
        if self.boundary == "SSSS":
            raise InvalidParameter(
                "Edges.boundary: found 'SSSS', which a plate has without effects, expected other edges; leave "
                "the effect out"
            )

    def stages(self, scene: Surroundings, budget: Budget) -> tuple[Stage, ...]:
        del scene, budget
        settings = {"boundary": self.boundary}
        return (Stage("edges", ("plate",), "plate", f"{__name__}:held", settings, effect=self.kind),)


def held(boundary: str) -> "Callable[[Plate], Plate]":
    """The plate with these edges."""
    return lambda plate: replace(plate, boundary=boundary)
