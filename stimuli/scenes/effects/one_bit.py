"""The sign of the reversed responses: the largest focus of a peak voltage."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ...composition.effect import Effect, Stage, Surroundings

if TYPE_CHECKING:
    from ...time_reversal.focusing.quantiser import Quantiser


@dataclass(frozen=True)
class OneBit(Effect):
    """Amplifiers that switch between two voltages.

    >>> OneBit().slot
    'quantiser'
    """

    kind = "one_bit"
    slot = "quantiser"

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        del scene
        return (Stage("one_bit", (), "quantiser", f"{__name__}:rule"),)


def rule() -> "Callable[[], Quantiser]":
    """The sign."""
    from ...time_reversal.focusing.quantiser import OneBit as Sign

    return Sign
