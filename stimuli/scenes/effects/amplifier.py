"""An amplifier that rolls off, in learning and in emission."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ...composition.effect import Effect, Stage, Surroundings

if TYPE_CHECKING:
    from ...time_reversal.responses.responses import Responses
    from ..stages.emission import EmittedSignal


@dataclass(frozen=True)
class Amplifier(Effect):
    """A Butterworth low-pass: -3 dB at `cutoff_hz`; both defaults are unverified.

    >>> Amplifier().order
    1
    """

    kind = "amplifier"
    slot = "amplifier"
    positive = ("cutoff_hz", "order")

    cutoff_hz: float = 60e3
    order: int = 1

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        del scene
        settings = dict(vars(self))
        return (
            Stage("amplifier_in", ("learnt",), "learnt", f"{__name__}:heard_through", settings),
            Stage("amplifier_out", ("in_band",), "in_band", f"{__name__}:sent_through", settings),
        )


def heard_through(cutoff_hz: float, order: int) -> "Callable[[Responses], Responses]":
    """Responses of the amplifier and the plate."""
    from ...time_reversal.filters import Butterworth
    from ...time_reversal.responses.responses import through

    gain = Butterworth(cutoff_hz, order)
    return lambda learnt: through(learnt, gain)


def sent_through(cutoff_hz: float, order: int) -> "Callable[[EmittedSignal], EmittedSignal]":
    """What leaves the amplifier."""
    from ...time_reversal.filters import Butterworth
    from ..stages.emission import through

    gain = Butterworth(cutoff_hz, order)
    return lambda emission: through(emission, gain)
