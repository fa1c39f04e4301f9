"""All figures of the thesis's time-reversal chapters."""

from collections.abc import Callable, Mapping, Sequence
from typing import Final

import numpy as np
from matplotlib.figure import Figure

from tactometry.stimuli.time_reversal.design.closed_forms import Reverberation
from tactometry.stimuli.time_reversal.design.guide import Design, Transducers
from tactometry.stimuli.time_reversal.filters import Band
from tactometry.stimuli.time_reversal.finger import Contactor, force_loss
from tactometry.stimuli.time_reversal.focusing.focusing import Emission
from tactometry.stimuli.time_reversal.focusing.merit import (
    amplitude_by_subset_m,
    amplitude_over_count_m,
    contributions_m,
    resolution_per_focus_m,
)
from tactometry.stimuli.time_reversal.focusing.sigma_delta import SigmaDelta
from tactometry.stimuli.time_reversal.focusing.sound import noise
from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN, BOROFLOAT_33
from tactometry.stimuli.time_reversal.responses.responses import Point, impulse_responses
from tactometry.stimuli.time_reversal.screen.attenuation import TAU_S, Attenuation
from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE, Screen
from tactometry.stimuli.time_reversal.screen.transducer import DiscPatch

from . import closed_forms, focus, prototype

FOCUS: Final = (0.121, 0.093)
P1: Final = (0.205, 0.142)
FOCI: Final = [(x, y) for y in (0.045, 0.105, 0.165) for x in (0.05, 0.1, 0.15, 0.2, 0.25)]
RIG_BAND: Final = Emission(Band(200.0, 25e3, 200.0), 2 * TAU_S, 100e3)
UNFILTERED: Final = Emission(Band(200.0, 60e3, 200.0), 2 * TAU_S, 250e3)
FILTERED: Final = Emission(Band(20e3, 60e3, 200.0), 2 * TAU_S, 250e3)
FOUR: Final[Mapping[str, Emission]] = {
    "1 bit": UNFILTERED,
    "1 bit, filtered": FILTERED,
    "SDM": Emission(UNFILTERED.band, 2 * TAU_S, 1e6, quantiser=SigmaDelta(2)),
    "SDM, filtered": Emission(FILTERED.band, 2 * TAU_S, 1e6, quantiser=SigmaDelta(2)),
}


def rig(diameter_m: float, thickness_m: float = 2e-3) -> Screen:
    """Return the rig of chapter 3: discs along two sides of thick glass.

    Their positions are an unverified default.
    """
    plate = BOROFLOAT_33.plate(0.297, 0.21, thickness_m, "SSSS")
    x = np.linspace(0.03, 0.267, 4)
    discs = tuple(DiscPatch(float(at), y, diameter_m) for y in (0.025, 0.185) for at in x)
    return Screen(plate, discs, Attenuation(TAU_S))


PLATES: Final = {f"{h:g} mm": BOROFLOAT_33.plate(0.297, 0.21, h * 1e-3, "SSSS") for h in (2, 3)}
ROOM: Final = Reverberation(32, 25e3, TAU_S, 2 * TAU_S, A4_SCREEN.modal_density_s, 1.25)
BANDS: Final = [Band(0.0, 5e3), Band(5e3, 15e3), Band(15e3, 25e3)]
SUBSETS: Final = {"all 32": range(32), "every second": range(0, 32, 2), "every fourth": range(0, 32, 4)}
CONTACTORS: Final = [Contactor("finger"), *(Contactor(k, d) for k in ("soft", "rigid") for d in (5e-3, 10e-3))]


def _frequency_response() -> Figure:
    h = impulse_responses(rig(35e-3), [FOCUS], rate_hz=50e3, duration_s=60e-3, f_max_hz=10e3)
    return focus.frequency_response(h, 10e3)


def _decay_fit() -> Figure:
    h = impulse_responses(A4_PROTOTYPE, [FOCUS], rate_hz=100e3, duration_s=25e-3, f_max_hz=25e3)
    return focus.decay_fit(h.samples[0, 0], 100e3)


def _sound(emissions: Mapping[str, Emission] = FOUR) -> Figure:
    driven = {name: emission.drive(emission.responses(A4_PROTOTYPE, [FOCUS])) for name, emission in emissions.items()}
    return focus.sound_spectra({name: noise(A4_PROTOTYPE, signal, 125e3) for name, signal in driven.items()})


def _contributions() -> np.ndarray:
    return contributions_m(UNFILTERED.responses(A4_PROTOTYPE, FOCI), UNFILTERED.voltage_v)


def _resolution_of_foci(foci: Sequence[Point] = FOCI) -> Figure:
    widths = resolution_per_focus_m(A4_PROTOTYPE, foci, UNFILTERED)
    expected_m = Design(A4_SCREEN, Transducers(), UNFILTERED.band, TAU_S, UNFILTERED.reversal_s).resolution_m
    return prototype.resolution_of_foci(widths, expected_m)


def _force_loss(forces_n: Sequence[float] = (0.0, 0.25, 0.5, 1.0, 2.0, 3.0, 4.0)) -> Figure:
    rows = force_loss(A4_PROTOTYPE, FOCUS, {"P1": P1, "F": FOCUS}, CONTACTORS, forces_n, RIG_BAND)
    return prototype.loss_over_force(rows)


GALLERY: Final[Mapping[str, Callable[..., Figure]]] = {
    "3.8-focus-map": lambda emission=RIG_BAND: focus.displacement_map(rig(35e-3), FOCUS, emission),
    "3.9-resolution-over-bandwidth": lambda: closed_forms.resolution_over_bandwidth(PLATES),
    "3.11-amplitude-over-bandwidth": lambda: focus.amplitude_over_bandwidth(
        {"12 mm discs": rig(12e-3), "35 mm discs": rig(35e-3)}, FOCUS, RIG_BAND
    ),
    "3.13-scans-per-band": lambda emission=RIG_BAND: focus.scans_per_band(rig(35e-3), FOCUS, BANDS, emission),
    "3.14-frequency-response": _frequency_response,
    "3.15-stress-and-deflection": lambda: closed_forms.stress_and_deflection_over_thickness(A4_SCREEN),
    "3.16-resolution-over-mean-frequency": lambda: closed_forms.resolution_over_mean_frequency(A4_SCREEN),
    "3.18-amplitude-over-reversal": lambda: closed_forms.amplitude_over_reversal(TAU_S, np.linspace(0, 20e-3, 100)),
    "3.21-contrast": lambda: closed_forms.contrast_over_transducers(
        ROOM, (1, 4, 8, 32), np.linspace(0.2e-3, 15e-3, 80)
    ),
    "4.9-modulator-noise": focus.modulator_noise,
    "4.11-decay-fit": _decay_fit,
    "4.13-noise-window": lambda: focus.noise_window(A4_PROTOTYPE, FOCUS, RIG_BAND),
    "4.15-four-signals": lambda emissions=FOUR: focus.four_signals(A4_PROTOTYPE, FOCUS, emissions),
    "4.25-sound": _sound,
    "4.28-layout": lambda: prototype.layout(A4_PROTOTYPE, FOCI),
    "4.29-amplitude-per-transducer": lambda: prototype.amplitude_per_transducer(_contributions()),
    "4.30-amplitude-over-count": lambda: prototype.amplitude_over_count(
        amplitude_over_count_m(_contributions(), np.random.default_rng(0))
    ),
    "4.31-amplitude-by-subset": lambda: prototype.amplitude_by_subset(amplitude_by_subset_m(_contributions(), SUBSETS)),
    "4.34-resolution-of-foci": _resolution_of_foci,
    "5.4-force-loss": _force_loss,
    "5.8-patterns": focus.pattern_waveforms,
}
