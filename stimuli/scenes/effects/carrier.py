"""An amplitude-modulated carrier: the force vibrates at the programmed frequency whatever the skin leaks."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, get_args

from tactometry.arguments import require
from tactometry.errors import InvalidParameter

from ...composition.effect import Effect, Stage, Surroundings

if TYPE_CHECKING:
    from ...electrovibration.waveforms.waveform import Waveform

Modulation = Literal["square_root", "full", "suppressed_carrier"]


@dataclass(frozen=True)
class Carrier(Effect):
    """A carrier of at least twice the programmed frequency; 2 kHz is an unverified default.

    >>> Carrier().modulation
    'square_root'
    """

    kind = "carrier"
    slot = "carrier"

    carrier_hz: float = 2_000.0
    modulation: Modulation = "square_root"

    def __post_init__(self) -> None:
        require.positive("Carrier", carrier_hz=self.carrier_hz)
        require.one_of("Carrier.modulation", self.modulation, get_args(Modulation))

    def stages(self, scene: Surroundings) -> tuple[Stage, ...]:
        del scene
        settings = {"carrier_hz": self.carrier_hz, "modulation": self.modulation}
        return (Stage("carrier", ("waveform",), "waveform", f"{__name__}:carried", settings),)


def carried(carrier_hz: float, modulation: Modulation) -> "Callable[[Waveform], Waveform]":
    """A tone as the envelope of a carrier."""
    from ...electrovibration.waveforms.amplitude_modulated import AmplitudeModulated
    from ...electrovibration.waveforms.sine import Sine

    def modulated(tone: "Waveform") -> "Waveform":
        if not isinstance(tone, Sine):
            raise InvalidParameter(f"carrier: found a {type(tone).__name__} to carry, expected a sine")
        return AmplitudeModulated(
            tone.frequency_hz,
            carrier_hz,
            tone.duration_s,
            tone.ramp_s,
            max(tone.rate_hz, 2.5 * (carrier_hz + tone.frequency_hz)),
            modulation,
            tone.level_unit,
        )

    return modulated
