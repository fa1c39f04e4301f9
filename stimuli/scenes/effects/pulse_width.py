"""Pulse-width modulation of the reversed responses."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tactometry.arguments import require
from tactometry.errors import InvalidParameter

from ...composition.effect import Effect, Stage, Surroundings

if TYPE_CHECKING:
    from ...time_reversal.focusing.quantiser import Quantiser


@dataclass(frozen=True)
class PulseWidth(Effect):
    """Two voltages, switched where the waveform crosses a triangle of `carrier_hz`, at most a quarter of the rate.

    >>> PulseWidth(carrier_hz=60e3).slot
    'quantiser'
    """

    kind = "pulse_width"
    slot = "quantiser"

    carrier_hz: float
    scale: float = 1.0

    def __post_init__(self) -> None:
        require.positive("PulseWidth", carrier_hz=self.carrier_hz, scale=self.scale)

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        rate_hz: float = scene.surface.rate_hz
        if 4 * self.carrier_hz > rate_hz:
            raise InvalidParameter(
                f"pulse_width: found a carrier of {self.carrier_hz} Hz, expected at most a quarter of rate_hz, "
                f"{rate_hz / 4} Hz; lower it or raise rate_hz"
            )
        settings = {"carrier_hz": self.carrier_hz, "scale": self.scale}
        return (Stage("pulse_width", (), "quantiser", f"{__name__}:rule", settings),)


def rule(carrier_hz: float, scale: float) -> "Callable[[], Quantiser]":
    """The comparison with the triangle."""
    from ...time_reversal.focusing.quantiser import PulseWidth as Comparison

    comparison = Comparison(carrier_hz, scale)
    return lambda: comparison
