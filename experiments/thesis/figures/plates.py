"""Figures of plates in chapters 3 to 5."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure

from tactometry.palette import BLACK, BLUE, ORANGE
from tactometry.stimuli.time_reversal.design.closed_forms import (
    Reverberation,
    analogue_amplitude_ratio,
    contrast_limit,
    contrast_whole,
    half_wavelength_m,
    one_bit_amplitude_ratio,
    repetition_amplitude_ratio,
    resolution_m,
)
from tactometry.stimuli.time_reversal.design.guide import Design, Transducers
from tactometry.stimuli.time_reversal.figures.theory import colours, label, sheet
from tactometry.stimuli.time_reversal.filters import Band
from tactometry.stimuli.time_reversal.finger import Contactor, force_loss
from tactometry.stimuli.time_reversal.focusing.focusing import Emission, emitted
from tactometry.stimuli.time_reversal.focusing.merit import (
    amplitude_by_subset_m,
    amplitude_over_count_m,
    contributions_m,
    resolution_per_focus_m,
)
from tactometry.stimuli.time_reversal.focusing.sound import noise
from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN
from tactometry.stimuli.time_reversal.plate.statics import bending_stress_pa, deflection_m
from tactometry.stimuli.time_reversal.responses.responses import Point, impulse_responses
from tactometry.stimuli.time_reversal.screen.attenuation import TAU_S
from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE

from ..setups import FOCI, FOCUS, FOUR, P1, RIG_BAND, UNFILTERED, one_sided, rig, thick_plate
from . import focus

REPETITION_S, T_MS, TAU_MS = 10e-3, 1e3 * RIG_BAND.reversal_s, 1e3 * TAU_S
TIMES = f"T = {T_MS:g} ms, T_r = {1e3 * REPETITION_S:g} ms, τ = {TAU_MS:g} ms"
PRESSED_N, CONTACT_M = 2.0, 10e-3
ROOM = Reverberation(32, 25e3, TAU_S, 2 * TAU_S, A4_SCREEN.modal_density_s, 1.25)
BANDS = [Band(0.0, 5e3), Band(5e3, 15e3), Band(15e3, 25e3)]
SUBSETS = {"all 32": range(32), "every second": range(0, 32, 2), "every fourth": range(0, 32, 4)}
CONTACTORS = [Contactor("finger"), *(Contactor(k, d) for k in ("soft", "rigid") for d in (5e-3, 10e-3))]


def modal_density() -> Figure:
    """Draw the characteristic time (modal density) against thickness (3.4)."""
    figure, (axes,) = sheet()
    thickness_mm = np.linspace(0.4, 3.0, 40)
    plates = [thick_plate(1e-3 * h) for h in thickness_mm]
    axes.plot(thickness_mm, [1e3 * plate.modal_density_s for plate in plates], color=BLUE, label="S / 2 sqrt(ρ_s / D)")
    counted = [len(plate.frequencies_hz(25e3)) / 25.0 for plate in plates[::6]]
    axes.plot(thickness_mm[::6], counted, "o", color=ORANGE, label="modes counted from 0 to 25 kHz")
    label(axes, "Thickness (mm)", "Characteristic time (ms) = modes per kHz", from_zero=True)
    return figure


def resolution_over_bandwidth() -> Figure:
    """Plot resolution against bandwidth (3.9, 3.10)."""
    figure, (axes,) = sheet()
    f_max = np.linspace(2e3, 25e3, 60)
    for h_mm, colour in zip((2, 3), colours(), strict=False):
        widths = [resolution_m(thick_plate(1e-3 * h_mm), Band(0.0, float(f))) for f in f_max]
        axes.plot(f_max / 1e3, np.multiply(widths, 1e3), color=colour, label=f"{h_mm} mm, diffuse-field model")
    label(axes, "Bandwidth from 0 (kHz)", "Resolution at −6 dB (mm)", from_zero=True)
    return figure


def resolution_over_mean_frequency() -> Figure:
    """Plot resolution against mean frequency (3.16, 4.23)."""
    figure, (axes,) = sheet()
    f = np.linspace(2e3, 60e3, 200)
    axes.plot(f / 1e3, half_wavelength_m(A4_SCREEN, f) * 1e3, color=BLUE, label="half a wavelength")
    widths = [resolution_m(A4_SCREEN, Band(0.0, 2 * float(x))) for x in f[::10]]
    axes.plot(f[::10] / 1e3, np.multiply(widths, 1e3), ".", color=BLACK, label="flat band from 0")
    label(axes, "Mean frequency (kHz)", "Resolution at −6 dB (mm)", from_zero=True)
    return figure


def stress_and_deflection_over_thickness() -> Figure:
    """Plot bending stress and deflection under a central force (3.15)."""
    thickness = np.linspace(0.4e-3, 3e-3, 40)
    plates = [replace(A4_SCREEN, thickness_m=float(h), boundary="SSSS") for h in thickness]
    middle = (A4_SCREEN.length_m / 2, A4_SCREEN.width_m / 2)
    stress = [bending_stress_pa(one, PRESSED_N, CONTACT_M) for one in plates]
    deflection = [deflection_m(one, PRESSED_N, middle, *middle)[0] for one in plates]
    figure, (left, right) = sheet(1, 2, width_in=8.0)
    left.semilogy(thickness * 1e3, np.divide(stress, 1e6), color=BLUE)
    right.semilogy(thickness * 1e3, np.multiply(deflection, 1e6), color=ORANGE)
    label(left, "Thickness (mm)", "Largest bending stress (MPa)", f"{PRESSED_N:g} N over {CONTACT_M * 1e3:g} mm")
    label(right, "Thickness (mm)", "Largest deflection (µm)", f"{PRESSED_N:g} N at the centre")
    return figure


def amplitude_over_reversal() -> Figure:
    """Plot amplitude against reversal time, re an endless one (3.18, 4.12)."""
    figure, (axes,) = sheet()
    reversal_s = np.linspace(0, 20e-3, 100)
    one_bit, analogue = one_bit_amplitude_ratio(reversal_s, TAU_S), analogue_amplitude_ratio(reversal_s, TAU_S)
    axes.plot(1e3 * reversal_s, 100 * one_bit, color=BLUE, label="1 bit, 1 − exp(−T/τ)")
    axes.plot(1e3 * reversal_s, 100 * analogue, "--", color=ORANGE, label="analogue, 1 − exp(−2T/τ)")
    axes.axvline(2 * TAU_MS, color=BLACK, linewidth=0.8, linestyle=":")
    axes.annotate(" T = 2τ", (2 * TAU_MS, 5))
    title = f"τ = {TAU_MS:g} ms"
    label(axes, "Reversal time T (ms)", "Amplitude (% of an endless reversal)", title, loc="center right")
    return figure


def contrast_over_transducers() -> Figure:
    """Plot contrast against reversal time by transducers (3.21, 4.14)."""
    figure, (axes,) = sheet()
    reversal_s = np.linspace(0.2e-3, 15e-3, 80)
    for q, colour in zip((1, 4, 8, 32), colours(), strict=False):
        rooms = [replace(ROOM, n_channels=q, reversal_s=float(t)) for t in reversal_s]
        axes.plot(reversal_s * 1e3, [contrast_whole(one) for one in rooms], color=colour, label=f"Q = {q}")
    axes.axhline(contrast_limit(ROOM), color=BLACK, linestyle=":", label="√N, all modes")
    label(axes, "Reversal time T (ms)", "Contrast, A / rms of the plate", from_zero=True, ncols=2)
    return figure


def repeated_focus() -> Figure:
    """Draw the displacement of a focus that is repeated four times (3.19)."""
    figure, (axes,) = sheet(width_in=7.2, height_in=3.2)
    axes.plot(*_train(4), color=BLUE, linewidth=0.6)
    for n in range(4):
        axes.axvline(T_MS + 1e3 * n * REPETITION_S, color=BLACK, linewidth=0.6, linestyle=":")
    label(axes, "Time (ms)", "Displacement (µm)", f"{TIMES}; dotted: foci")
    return figure


def _train(n_foci: int) -> tuple[np.ndarray, np.ndarray]:
    """Return time (ms) and displacement (um) of the focus."""
    responses = RIG_BAND.responses(A4_PROTOTYPE, [FOCUS])
    once = emitted(RIG_BAND.drive(responses), responses)[0]
    step = round(REPETITION_S * RIG_BAND.rate_hz)
    u = np.zeros(len(once) + step * (n_foci - 1))
    for start in range(0, step * n_foci, step):
        u[start : start + len(once)] += once
    return np.arange(len(u)) / RIG_BAND.rate_hz * 1e3, 1e6 * u


def time_constants() -> Figure:
    """Draw T, T_r and tau, and the amplitude that a short T_r costs (3.20)."""
    figure, (train, cost) = sheet(2, 1, width_in=7.2, height_in=6.0)
    t_ms, u_um = _train(2)
    train.plot(t_ms, u_um, color=BLUE, linewidth=0.6)
    between_ms, largest_um = 1e3 * REPETITION_S, float(u_um.max())
    after_ms = np.linspace(0, between_ms, 100)
    decay_um = 0.2 * largest_um * np.exp(-after_ms / TAU_MS)
    train.plot(T_MS + after_ms, decay_um, "--", color=ORANGE, label="exp(−t/τ)")
    look = {"arrowstyle": "<->", "shrinkA": 0, "shrinkB": 0}
    for name, start_ms, end_ms in (("T", 0.0, T_MS), ("T_r", T_MS, T_MS + between_ms)):
        height_um = 0.7 * largest_um
        train.annotate("", (start_ms, height_um), (end_ms, height_um), arrowprops=look)
        train.annotate(name, ((start_ms + end_ms) / 2, 0.74 * largest_um), ha="center")
    label(train, "Time (ms)", "Displacement (µm)", TIMES, loc="upper right")

    repetition_s = np.linspace(1e-3, 15e-3, 60)
    for taus, colour in ((1.0, ORANGE), (2.0, BLUE), (3.0, BLACK)):
        shares = [repetition_amplitude_ratio(taus * TAU_S, float(t), TAU_S) for t in repetition_s]
        cost.plot(1e3 * repetition_s, 100 * np.array(shares), color=colour, label=f"T = {taus:g} τ")
    label(cost, "Repetition time T_r (ms)", "Amplitude (% of a single focus)", from_zero=True)
    return figure


def frequency_response() -> Figure:
    """Plot the response spectrum at the focus of the rig (3.14)."""
    h = impulse_responses(rig(35e-3), [FOCUS], rate_hz=50e3, duration_s=60e-3, f_max_hz=10e3)
    return focus.frequency_response(h, 10e3)


def decay_fit() -> Figure:
    """Plot a decay that is fitted to an impulse response (4.11)."""
    h = impulse_responses(A4_PROTOTYPE, [FOCUS], rate_hz=100e3, duration_s=25e-3, f_max_hz=25e3)
    return focus.decay_fit(h.samples[0, 0], 100e3)


def sound(emissions: Mapping[str, Emission] = FOUR) -> Figure:
    """Plot the sound of the driving signals (4.25)."""
    driven = {name: emission.drive(emission.responses(A4_PROTOTYPE, [FOCUS])) for name, emission in emissions.items()}
    return focus.sound_spectra({name: noise(A4_PROTOTYPE, signal, 125e3) for name, signal in driven.items()})


def _contributions() -> np.ndarray:
    return contributions_m(UNFILTERED.responses(A4_PROTOTYPE, FOCI), UNFILTERED.voltage_v)


def one_sided_resolution(foci: Sequence[Point] = FOCI) -> Figure:
    """Draw the resolution of each focus of the one-sided layout (4.34)."""
    widths_m = resolution_per_focus_m(one_sided(), foci, UNFILTERED)
    expected = Design(A4_SCREEN, Transducers(), UNFILTERED.band, TAU_S, UNFILTERED.reversal_s)
    return focus.resolution_of_foci(widths_m, expected.resolution_m)


def loss_over_force(forces_n: Sequence[float] = (0.0, 0.25, 0.5, 1.0, 2.0, 3.0, 4.0)) -> Figure:
    """Plot the simulated loss of amplitude of the prototype (5.4)."""
    rows = force_loss(A4_PROTOTYPE, FOCUS, {"P1": P1, "F": FOCUS}, CONTACTORS, forces_n, RIG_BAND)
    return focus.loss_over_force(rows)


ASSUMES = (
    "Plate, edges, layout, tau (from finding-2), band and drive of the gallery (unverified defaults). Amplitudes are "
    "proportional to the moment per volt of a patch, set so that one bit gives 10 um at 30 V."
)
DRAWN: Mapping[str, Callable[..., Figure]] = {
    "3.4": modal_density,
    "3.8": lambda emission=RIG_BAND: focus.displacement_map(rig(35e-3), FOCUS, emission),
    "3.9": resolution_over_bandwidth,
    "3.11": lambda: focus.amplitude_over_bandwidth({f"{d} mm discs": rig(1e-3 * d) for d in (12, 35)}, FOCUS, RIG_BAND),
    "3.13": lambda emission=RIG_BAND: focus.scans_per_band(rig(35e-3), FOCUS, BANDS, emission),
    "3.14": frequency_response,
    "3.15": stress_and_deflection_over_thickness,
    "3.16": resolution_over_mean_frequency,
    "3.18": amplitude_over_reversal,
    "3.19": repeated_focus,
    "3.20": time_constants,
    "3.21": contrast_over_transducers,
    "4.9": focus.modulator_noise,
    "4.11": decay_fit,
    "4.13": lambda: focus.noise_window(A4_PROTOTYPE, FOCUS, RIG_BAND),
    "4.15": lambda emissions=FOUR: focus.four_signals(A4_PROTOTYPE, FOCUS, emissions),
    "4.25": sound,
    "4.28": lambda: focus.layout(A4_PROTOTYPE, FOCI),
    "4.29": lambda: focus.amplitude_per_transducer(_contributions()),
    "4.30": lambda: focus.amplitude_over_count(amplitude_over_count_m(_contributions(), np.random.default_rng(0))),
    "4.31": lambda: focus.amplitude_by_subset(amplitude_by_subset_m(_contributions(), SUBSETS)),
    "4.33": lambda: focus.layout(one_sided(), FOCI),
    "4.34": one_sided_resolution,
    "5.4": loss_over_force,
    "5.8": focus.pattern_waveforms,
}
"""Function that returns each figure. Arguments make some of them smaller."""
