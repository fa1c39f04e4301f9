"""Resistance of body and source in series with the skin."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from tactometry.arguments import require

from ...composition.effect import Effect, Stage, Surroundings
from ..stages.circuit import circuit_stage

if TYPE_CHECKING:
    from ...electrovibration.skin.skin import Skin


@dataclass(frozen=True)
class BodyResistance(Effect):
    """A resistance above 0. With it the waveform of the force depends on the contact area.

    >>> BodyResistance(resistance_ohm=1e4).slot
    'body'
    """

    kind = "body_resistance"
    slot = "body"

    resistance_ohm: float

    def __post_init__(self) -> None:
        require.positive("BodyResistance", resistance_ohm=self.resistance_ohm)

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        del scene
        body = Stage(
            "body_resistance", ("skin",), "skin", f"{__name__}:in_series", {"resistance_ohm": self.resistance_ohm}
        )
        return body, circuit_stage(self.kind)


def in_series(resistance_ohm: float) -> "Callable[[Skin], Skin]":
    """The skin in series with a resistance."""
    return lambda skin: replace(skin, body_resistance_ohm=resistance_ohm)
