"""Sigma-delta modulation of the reversed responses."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tactometry.arguments import require
from tactometry.errors import InvalidParameter

from ...composition.effect import Effect, Stage, Surroundings

if TYPE_CHECKING:
    from ...time_reversal.focusing.quantiser import Quantiser


@dataclass(frozen=True)
class SigmaDelta(Effect):
    """One bit per sample, of `order` 1 or 2; `scale` is the peak of the modulator's input.

    >>> SigmaDelta().order
    2
    """

    kind = "sigma_delta"
    slot = "quantiser"

    order: int = 2
    scale: float = 0.7

    def __post_init__(self) -> None:
        if self.order not in {1, 2}:
            raise InvalidParameter(f"SigmaDelta.order: found {self.order}, expected 1 or 2")
        require.positive("SigmaDelta", scale=self.scale)

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        del scene
        settings = {"order": self.order, "scale": self.scale}
        return (Stage("sigma_delta", (), "quantiser", f"{__name__}:rule", settings),)


def rule(order: int, scale: float) -> "Callable[[], Quantiser]":
    """The modulator."""
    from ...time_reversal.focusing.quantiser import SigmaDelta as Modulator

    modulator = Modulator(order, scale)
    return lambda: modulator
