"""The four driving signals of chapter 4 on the prototype: focus, power and sound of each, computed once."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

from tactometry.stimuli.time_reversal.field.field import field, grid
from tactometry.stimuli.time_reversal.field.merit import (
    contrast_whole_of,
    resolution_per_focus_m,
    switched_power_w,
    temporal_width_s,
)
from tactometry.stimuli.time_reversal.field.sound import noise
from tactometry.stimuli.time_reversal.figures.gallery import FOCUS, FOUR
from tactometry.stimuli.time_reversal.focusing.focusing import Emission, emitted, focus_amplitude
from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE

from .table_4_1 import patch_capacitance_f

N_X, N_Y = 120, 85
SOUND_TO_HZ = 125e3
ASSUMES = (
    "A4, 1.1 mm Borofloat with supported edges, 32 patches along the border, 30 V, tau = 3.5 ms, T = 7 ms, 0.2-60 kHz "
    "unfiltered and 20-60 kHz filtered, one focus; sigma-delta modulation (SDM) of order 2 at 1 MHz (all unverified "
    "defaults)."
)


@dataclass(frozen=True)
class DrivenFocus:
    """What one driving signal gives."""

    amplitude_m: float
    temporal_width_s: float
    width_m: float
    contrast: float
    power_w: float
    sound_dba: float
    emission: Emission


@lru_cache(maxsize=1)
def measured() -> Mapping[str, DrivenFocus]:
    """By the name of the signal."""
    return {name: _measure(emission) for name, emission in FOUR.items()}


def _measure(emission: Emission) -> DrivenFocus:
    heard = emission.responses(A4_PROTOTYPE, [FOCUS])
    signal = emission.drive(heard)
    amplitude_m = focus_amplitude(signal, heard)
    at_focus = field(A4_PROTOTYPE, signal, signal.samples.shape[1] - 1, grid(A4_PROTOTYPE, N_X, N_Y), emission.f_max_hz)
    return DrivenFocus(
        amplitude_m,
        temporal_width_s(emitted(signal, heard)[0], emission.rate_hz),
        float(resolution_per_focus_m(A4_PROTOTYPE, [FOCUS], emission).mean()),
        contrast_whole_of(amplitude_m, at_focus),
        switched_power_w(signal, patch_capacitance_f()),
        noise(A4_PROTOTYPE, signal, SOUND_TO_HZ).a_weighted_db,
        emission,
    )
