"""The sign of the reversed responses: the largest focus of a peak voltage."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from ..effect import Surroundings
from ..stage import Stage

if TYPE_CHECKING:
    from ...time_reversal.focusing.quantiser import Quantiser


@dataclass(frozen=True)
class OneBit:
    """Amplifiers that switch between two voltages.

    >>> OneBit().slot
    'quantiser'
    """

    kind: ClassVar[str] = "one_bit"
    slot: ClassVar[str] = "quantiser"
    requires: ClassVar[tuple[str, ...]] = ()
    excludes: ClassVar[Mapping[str, str]] = {}
    assumes: ClassVar[tuple[str, ...]] = ()

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        del scene
        return (Stage("one_bit", (), "quantiser", f"{__name__}:rule", effect=self.kind),)


def rule() -> "Callable[[], Quantiser]":
    """The sign."""
    from ...time_reversal.focusing.quantiser import OneBit as Sign

    return Sign
