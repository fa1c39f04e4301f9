"""Air between the insulator and the skin."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

from tactometry.arguments import require

from ..effect import Surroundings
from ..stage import Stage

if TYPE_CHECKING:
    from ...electrovibration.skin.skin import Skin


@dataclass(frozen=True)
class AirGap:
    """A gap of `gap_m`, above 0.

    >>> AirGap(gap_m=1e-6).slot
    'gap'
    """

    kind: ClassVar[str] = "air_gap"
    slot: ClassVar[str] = "gap"
    requires: ClassVar[tuple[str, ...]] = ()
    excludes: ClassVar[Mapping[str, str]] = {}
    assumes: ClassVar[tuple[str, ...]] = ("the gap is even under the whole contact",)

    gap_m: float

    def __post_init__(self) -> None:
        require.positive("AirGap", gap_m=self.gap_m)

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        del scene
        return (Stage("air_gap", ("skin",), "skin", f"{__name__}:parted", {"gap_m": self.gap_m}, effect=self.kind),)


def parted(gap_m: float) -> "Callable[[Skin], Skin]":
    """The skin behind a gap."""
    return lambda skin: replace(skin, gap_m=gap_m)
