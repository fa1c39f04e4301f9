"""An amplitude-modulated carrier instead of a tone."""

from dataclasses import dataclass
from math import pi
from typing import TYPE_CHECKING, Literal, get_args

from tactometry.arguments import require
from tactometry.errors import InvalidParameter

from ...composition.content import VoltageContent
from ...composition.effect import Effect, Surroundings

if TYPE_CHECKING:
    from ...electrovibration.waveforms.waveform import Waveform

Modulation = Literal["square_root", "full", "suppressed_carrier"]


@dataclass(frozen=True)
class Carrier(Effect):
    """An amplitude-modulated carrier; 2 kHz is an unverified default.

    Parameters
    ----------
    carrier_hz : float
        Carrier frequency, at least twice the programmed frequency.
    modulation : {"square_root", "full", "suppressed_carrier"}
        Shape of the envelope, as in `tactometry.stimuli.electrovibration.AmplitudeModulated`.
    """

    kind = "carrier"
    positive = ("carrier_hz",)
    reads, gives = ("waveform",), "waveform"
    in_signal = True

    carrier_hz: float = 2_000.0
    modulation: Modulation = "square_root"

    def __post_init__(self) -> None:
        super().__post_init__()
        require.one_of("Carrier.modulation", self.modulation, get_args(Modulation))

    def __call__(self, tone: "Waveform") -> "Waveform":
        from ...electrovibration.waveforms.amplitude_modulated import AmplitudeModulated
        from ...electrovibration.waveforms.sine import Sine

        if not isinstance(tone, Sine):
            raise InvalidParameter(f"carrier: found a {type(tone).__name__} tone, expected a sine")
        return AmplitudeModulated(
            tone.frequency_hz,
            self.carrier_hz,
            tone.duration_s,
            tone.ramp_s,
            max(tone.rate_hz, 2.5 * (self.carrier_hz + tone.frequency_hz)),
            self.modulation,
            tone.level_unit,
        )

    def in_voltage(self, scene: Surroundings) -> VoltageContent:
        has_kinks = self.modulation == "square_root"
        envelope_rad_per_s = pi * scene.surface.frequency_hz if has_kinks else 0.0
        return VoltageContent(self.carrier_hz, self.carrier_hz, envelope_rad_per_s)
