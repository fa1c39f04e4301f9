"""Registry of the waveforms that a study can name, by kind."""

from collections.abc import Mapping
from typing import Final, NamedTuple


class WaveformKind(NamedTuple):
    """Import path of a waveform class, and an example of its fields.

    The example sets the fields without a default. Tests of all stimuli and the key reference use it.
    """

    target: str
    example: Mapping[str, object]


_TONE: Final = {"frequency_hz": 60.0}

WAVEFORMS: Final[Mapping[str, WaveformKind]] = {
    "amplitude_modulated": WaveformKind(f"{__package__}.amplitude_modulated:AmplitudeModulated", _TONE),
    "sine": WaveformKind(f"{__package__}.sine:Sine", _TONE),
    "square": WaveformKind(f"{__package__}.periodic:Square", _TONE),
    "triangle": WaveformKind(f"{__package__}.periodic:Triangle", _TONE),
    "trapezoid": WaveformKind(
        f"{__package__}.periodic:Trapezoid", {"rise_s": 1e-3, "high_s": 2e-3, "fall_s": 1e-3, "low_s": 2e-3}
    ),
    "pulse_train": WaveformKind(f"{__package__}.periodic:PulseTrain", {**_TONE, "width_s": 1e-3}),
    "step": WaveformKind(f"{__package__}.step:Step", {}),
}
