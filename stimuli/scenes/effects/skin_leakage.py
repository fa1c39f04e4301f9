"""The stratum corneum leaks: its voltage is the applied one through a high-pass, exactly."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from tactometry.arguments import require

from ...composition.effect import Effect, Stage, Surroundings
from ..stages.circuit import circuit_stage

if TYPE_CHECKING:
    from ...electrovibration.skin.skin import Skin


@dataclass(frozen=True)
class SkinLeakage(Effect):
    """Resistivity of the stratum corneum, above 0; 20 kohm m is an unverified default.

    >>> SkinLeakage().corneum_resistivity_ohm_m
    20000.0
    """

    kind = "skin_leakage"
    slot = "leakage"
    assumes = ("the corneum is the same at all frequencies",)

    corneum_resistivity_ohm_m: float = 2.0e4

    def __post_init__(self) -> None:
        require.positive("SkinLeakage", corneum_resistivity_ohm_m=self.corneum_resistivity_ohm_m)

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        del scene
        leaking = Stage(
            "skin_leakage",
            ("skin",),
            "skin",
            f"{__name__}:leaking",
            {"corneum_resistivity_ohm_m": self.corneum_resistivity_ohm_m},
        )
        return leaking, circuit_stage(self.kind)


def leaking(corneum_resistivity_ohm_m: float) -> "Callable[[Skin], Skin]":
    """The skin with a corneum that conducts."""
    return lambda skin: replace(skin, corneum_resistivity_ohm_m=corneum_resistivity_ohm_m)
