"""Figures of plates in chapters 3 and 4."""

from collections.abc import Callable

import numpy as np
from matplotlib.figure import Figure

from tactometry.palette import BLACK, BLUE, ORANGE
from tactometry.stimuli.time_reversal.design.closed_forms import repetition_amplitude_ratio
from tactometry.stimuli.time_reversal.design.guide import Design, Transducers
from tactometry.stimuli.time_reversal.figures.style import label, sheet
from tactometry.stimuli.time_reversal.focusing.focusing import emitted
from tactometry.stimuli.time_reversal.focusing.merit import resolution_per_focus_m
from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN, BOROFLOAT_33
from tactometry.stimuli.time_reversal.screen.attenuation import TAU_S, Attenuation
from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE, Screen
from tactometry.stimuli.time_reversal.screen.transducer import SIDE_M, Patch

from ..reproduction import Origin, Reproduction
from . import prototype
from .gallery import FOCI, FOCUS, GALLERY, RIG_BAND, UNFILTERED

REPETITION_S, T_MS, TAU_MS = 10e-3, 1e3 * RIG_BAND.reversal_s, 1e3 * TAU_S
TIMES = f"T = {T_MS:g} ms, T_r = {1e3 * REPETITION_S:g} ms, τ = {TAU_MS:g} ms"
N_COLUMNS, STEP_M, EDGE_M = 16, 18e-3, 13.5e-3


def modal_density() -> Figure:
    """Draw the characteristic time against thickness (3.4)."""
    figure, (axes,) = sheet()
    thickness_mm = np.linspace(0.4, 3.0, 40)
    plates = [BOROFLOAT_33.plate(0.297, 0.21, 1e-3 * h, "SSSS") for h in thickness_mm]
    axes.plot(thickness_mm, [1e3 * plate.modal_density_s for plate in plates], color=BLUE, label="S / 2 sqrt(ρ_s / D)")
    counted = [len(plate.frequencies_hz(25e3)) / 25.0 for plate in plates[::6]]
    axes.plot(thickness_mm[::6], counted, "o", color=ORANGE, label="modes counted from 0 to 25 kHz")
    label(axes, "Thickness (mm)", "Characteristic time (ms) = modes per kHz", from_zero=True)
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
    heard = RIG_BAND.responses(A4_PROTOTYPE, [FOCUS])
    once = emitted(RIG_BAND.drive(heard), heard)[0]
    step = round(REPETITION_S * RIG_BAND.rate_hz)
    u = np.zeros(len(once) + step * (n_foci - 1))
    for start in range(0, step * n_foci, step):
        u[start : start + len(once)] += once
    return np.arange(len(u)) / RIG_BAND.rate_hz * 1e3, 1e6 * u


def time_constants() -> Figure:
    """Draw time and attenuation constants and their costs (3.20)."""
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


def one_sided() -> Screen:
    """Return 32 square patches in two rows along one long side.

    Positions are unverified defaults.
    """
    places = [(EDGE_M + STEP_M * column, EDGE_M + STEP_M * row) for row in range(2) for column in range(N_COLUMNS)]
    return Screen(A4_SCREEN, tuple(Patch(x, y, SIDE_M, SIDE_M) for x, y in places), Attenuation(TAU_S))


def one_sided_resolution() -> Figure:
    """Draw the resolution of each focus of the one-sided layout (4.34)."""
    widths_m = resolution_per_focus_m(one_sided(), FOCI, UNFILTERED)
    expected = Design(A4_SCREEN, Transducers(), UNFILTERED.band, TAU_S, UNFILTERED.reversal_s)
    return prototype.resolution_of_foci(widths_m, expected.resolution_m)


DERIVED: Origin = "derived"
SET: Origin = "calibrated"
CHOSEN: Origin = "assumed"
Drawn = tuple[Callable[[], Figure] | str, Origin, str, str]
OTHERS = "The thesis took it from other work."
DRAWN: dict[str, Drawn] = {
    "3.4": (modal_density, DERIVED, "Characteristic time and density of modes", ""),
    "3.8": ("3.8-focus-map", SET, "Focus at 0-25 kHz and a cut through it", ""),
    "3.9": ("3.9-resolution-over-bandwidth", DERIVED, "Resolution against bandwidth, 2 and 3 mm", ""),
    "3.11": ("3.11-amplitude-over-bandwidth", SET, "Amplitude with 12 and 35 mm discs", ""),
    "3.13": ("3.13-scans-per-band", SET, "Focus for several bands", ""),
    "3.14": ("3.14-frequency-response", SET, "Response at the focus to 10 kHz", ""),
    "3.15": ("3.15-stress-and-deflection", DERIVED, "Bending stress and deflection under 2 N", ""),
    "3.16": ("3.16-resolution-over-mean-frequency", DERIVED, "Resolution against mean frequency", ""),
    "3.18": ("3.18-amplitude-over-reversal", DERIVED, "Amplitude against reversal time", ""),
    "3.19": (repeated_focus, SET, "A focus repeated", OTHERS),
    "3.20": (time_constants, SET, "The time constants, and what a short repetition costs", ""),
    "3.21": (
        "3.21-contrast",
        DERIVED,
        "Contrast by transducers and reversal time",
        "The thesis took the first from other work.",
    ),
    "4.9": ("4.9-modulator-noise", DERIVED, "Quantisation noise of the modulators", ""),
    "4.11": ("4.11-decay-fit", CHOSEN, "Exponential fitted to an impulse response", ""),
    "4.13": ("4.13-noise-window", SET, "Focus in time, and the window of its noise", ""),
    "4.15": ("4.15-four-signals", SET, "The four driving signals in time and space", ""),
    "4.25": ("4.25-sound", SET, "Sound of the four driving signals", ""),
    "4.28": ("4.28-layout", CHOSEN, "Positions of transducers and foci", ""),
    "4.29": ("4.29-amplitude-per-transducer", SET, "Amplitude of each transducer alone", ""),
    "4.30": ("4.30-amplitude-over-count", SET, "Amplitude against number of transducers", ""),
    "4.31": ("4.31-amplitude-by-subset", SET, "Amplitude by subset of transducers", ""),
    "4.33": (
        lambda: prototype.layout(one_sided(), FOCI),
        CHOSEN,
        "32 square transducers on one side of the plate",
        "32 square transducers are on one side.",
    ),
    "4.34": (one_sided_resolution, DERIVED, "Resolution of each focus, patches on one side", ""),
}
"""Drawing or name in the gallery, origin, title, and statement of our sources next to the caption."""
ITEMS = {
    f"figure-{number}": Reproduction(
        title=title,
        stated=stated,
        assumes="Plate, edges, layout, tau (from finding-2), band and drive of the gallery (unverified defaults). "
        "Amplitudes are proportional to the moment per volt of a patch, set so that one bit gives 10 um at 30 V.",
        drawing=GALLERY[drawing] if isinstance(drawing, str) else drawing,
        origin=origin,
    )
    for number, (drawing, origin, title, stated) in DRAWN.items()
}
