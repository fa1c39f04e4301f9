"""Air between the insulator and the skin."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from tactometry.arguments import require

from ...composition.effect import Effect, Stage, Surroundings

if TYPE_CHECKING:
    from ...electrovibration.skin.skin import Skin


@dataclass(frozen=True)
class AirGap(Effect):
    """A gap of `gap_m`, above 0.

    >>> AirGap(gap_m=1e-6).slot
    'gap'
    """

    kind = "air_gap"
    slot = "gap"
    assumes = ("the gap is even under the whole contact",)

    gap_m: float

    def __post_init__(self) -> None:
        require.positive("AirGap", gap_m=self.gap_m)

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        del scene
        return (Stage("air_gap", ("skin",), "skin", f"{__name__}:parted", {"gap_m": self.gap_m}),)


def parted(gap_m: float) -> "Callable[[Skin], Skin]":
    """The skin behind a gap."""
    return lambda skin: replace(skin, gap_m=gap_m)
