"""Tables 4.3 to 4.5 and finding 5: the four driving signals."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache

from tactometry.stimuli.time_reversal.focusing.focusing import Emission, emitted, focus_amplitude
from tactometry.stimuli.time_reversal.focusing.merit import (
    contrast_whole_of,
    field,
    grid,
    resolution_per_focus_m,
    switched_power_w,
    temporal_width_s,
)
from tactometry.stimuli.time_reversal.focusing.sound import noise
from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE
from tactometry.stimuli.time_reversal.screen.transducer import PATCH_CAPACITANCE_F

from .reproduction import Number
from .setups import FOCUS, FOUR

N_X, N_Y = 120, 85
SOUND_TO_HZ = 125e3
REPETITION_HZ, N_PATCHES = 100.0, 32
BEST, REFERENCE_M = "1 bit, filtered", 10e-6
ASSUMES = (
    "A4, 1.1 mm Borofloat, supported edges, 32 patches along the border, 30 V, tau = 3.5 ms, T = 7 ms, 0.2-60 kHz "
    "unfiltered and 20-60 kHz filtered, one focus, sigma-delta modulation (SDM) of order 2 at 1 MHz (unverified "
    "defaults; tau from finding-2)."
)


@dataclass(frozen=True)
class DrivenFocus:
    """Focus of one driving signal."""

    amplitude_m: float
    temporal_width_s: float
    width_m: float
    contrast: float
    power_w: float
    sound_dba: float
    emission: Emission

    @property
    def supply_v(self) -> float:
        """Supply voltage for 10 um."""
        return self.emission.voltage_v * REFERENCE_M / self.amplitude_m

    @property
    def sound_at_10_um_dba(self) -> float:
        return self.sound_dba + 20 * math.log10(REFERENCE_M / self.amplitude_m)


@lru_cache(maxsize=1)
def measurements() -> Mapping[str, DrivenFocus]:
    """Return the focus of each signal by name."""
    return {name: _measure(emission) for name, emission in FOUR.items()}


def _measure(emission: Emission) -> DrivenFocus:
    responses = emission.responses(A4_PROTOTYPE, [FOCUS])
    signal = emission.drive(responses)
    amplitude_m = focus_amplitude(signal, responses)
    at_focus = field(A4_PROTOTYPE, signal, signal.samples.shape[1] - 1, grid(A4_PROTOTYPE, N_X, N_Y), emission.f_max_hz)
    return DrivenFocus(
        amplitude_m,
        temporal_width_s(emitted(signal, responses)[0], emission.rate_hz),
        float(resolution_per_focus_m(A4_PROTOTYPE, [FOCUS], emission).mean()),
        contrast_whole_of(amplitude_m, at_focus),
        switched_power_w(signal, PATCH_CAPACITANCE_F),
        noise(A4_PROTOTYPE, signal, SOUND_TO_HZ).a_weighted_db,
        emission,
    )


def _performance() -> Iterator[Number]:
    largest_m = max(signal.amplitude_m for signal in measurements().values())
    for name, signal in measurements().items():
        yield Number("amplitude", name, 1e6 * signal.amplitude_m, "um", "calibrated")
        yield Number("of the largest", name, 100 * signal.amplitude_m / largest_m, "%", "derived")
        yield Number("temporal resolution", name, 1e6 * signal.temporal_width_s, "us", "derived")
        yield Number("spatial resolution", name, 1e3 * signal.width_m, "mm", "derived")
        yield Number("contrast", name, signal.contrast, "", "derived")


def _power() -> Iterator[Number]:
    for name, signal in measurements().items():
        energy_j = signal.power_w * signal.emission.reversal_s
        yield Number("power while emitting", name, signal.power_w, "W", "derived")
        yield Number("energy of a focus", name, 1e3 * energy_j, "mJ", "derived")
        yield Number("mean power, 100 foci/s", name, energy_j * REPETITION_HZ, "W", "derived")
        if signal.emission.quantiser is None:
            yield Number("analytical estimate", name, _analytical_w(signal), "W", "derived")


def _analytical_w(signal: DrivenFocus) -> float:
    """Return the analytical power Q C 2 V^2 r.

    r = 2 sqrt((b^3 - a^3) / (3 (b - a))) is the number of transitions per second of flat noise (Rice).
    """
    low_hz, high_hz = signal.emission.band.f_min_hz, signal.emission.band.f_max_hz
    transitions_hz = 2 * math.sqrt((high_hz**3 - low_hz**3) / (3 * (high_hz - low_hz)))
    return N_PATCHES * PATCH_CAPACITANCE_F * 2 * signal.emission.voltage_v**2 * transitions_hz


def _sound() -> Iterator[Number]:
    levels_db = {name: signal.sound_dba for name, signal in measurements().items()}
    first_db = next(iter(levels_db.values()))
    for name, level_db in levels_db.items():
        yield Number("A-weighted level", name, level_db, "dBA", "calibrated")
        bare, comma, _ = name.partition(", filtered")
        quieter = ("filtering the audible frequencies reduces the sound", level_db < levels_db[bare]) if comma else ()
        yield Number("re one bit unfiltered", name, level_db - first_db, "dB", "derived", *quieter)


def _comparison() -> Iterator[Number]:
    signals = measurements()
    loudest_db = max(signal.sound_dba for signal in signals.values())
    largest_m = max(signal.amplitude_m for signal in signals.values())
    strong = {name: signal for name, signal in signals.items() if signal.amplitude_m >= largest_m / 2}
    quietest = min(strong, key=lambda name: strong[name].sound_dba)
    for name, signal in signals.items():
        at_10_um_db = signal.sound_at_10_um_dba - signals["1 bit"].sound_at_10_um_dba
        is_best = ("best in amplitude and noise", name == quietest) if name == BEST else ()
        yield Number("amplitude, of the largest", name, 100 * signal.amplitude_m / largest_m, "%", "derived")
        yield Number("sound, re the loudest", name, signal.sound_dba - loudest_db, "dB", "derived")
        yield Number("sound at 10 um, re one bit", name, at_10_um_db, "dB", "derived")
        yield Number("supply for 10 um", name, signal.supply_v, "V", "calibrated")
        yield Number("quietest of half the amplitude", name, float(name == quietest), "", "derived", *is_best)
        for end, limit_m in zip(("from", "to"), _limits_as_quietest_m(signal), strict=True):
            yield Number(f"quietest for a limit {end}", name, 100 * limit_m / largest_m, "%", "derived")


def _limits_as_quietest_m(own: DrivenFocus) -> tuple[float, float]:
    """Return amplitudes between which a signal is quietest; equal if never."""
    quieter = [each.amplitude_m for each in measurements().values() if each.sound_dba < own.sound_dba]
    return min(max(quieter, default=0.0), own.amplitude_m), own.amplitude_m
