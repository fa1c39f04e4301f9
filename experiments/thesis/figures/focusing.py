"""Figures of chapters 3 and 4 that the gallery of time reversal does not have."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tactometry.palette import BLACK, BLUE, ORANGE
from tactometry.stimuli.time_reversal import emitted
from tactometry.stimuli.time_reversal.design.closed_forms import repetition_amplitude_ratio
from tactometry.stimuli.time_reversal.design.guide import Design, Transducers
from tactometry.stimuli.time_reversal.figures.style import label, sheet
from tactometry.stimuli.time_reversal.focusing.merit import resolution_per_focus_m
from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN, BOROFLOAT_33
from tactometry.stimuli.time_reversal.screen.attenuation import TAU_S, Attenuation
from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE, Screen
from tactometry.stimuli.time_reversal.screen.transducer import SIDE_M, Patch

from . import prototype
from .gallery import FOCI, FOCUS, RIG_BAND, UNFILTERED

REPETITION_S = 10e-3
N_COLUMNS, STEP_M, EDGE_M = 16, 18e-3, 13.5e-3


def one_sided() -> Screen:
    """32 square patches in two rows along one long side; their places are an unverified default."""
    places = [(EDGE_M + STEP_M * column, EDGE_M + STEP_M * row) for row in range(2) for column in range(N_COLUMNS)]
    return Screen(A4_SCREEN, tuple(Patch(x, y, SIDE_M, SIDE_M) for x, y in places), Attenuation(TAU_S))


def modal_density() -> Figure:
    """Characteristic time, which is the density of eigenmodes, against thickness, with modes counted (3.4)."""
    figure, (axes,) = sheet()
    thickness_mm = np.linspace(0.4, 3.0, 40)
    plates = [BOROFLOAT_33.plate(0.297, 0.21, 1e-3 * h, "SSSS") for h in thickness_mm]
    axes.plot(thickness_mm, [1e3 * plate.modal_density_s for plate in plates], color=BLUE, label="S / 2 sqrt(ρ_s / D)")
    few = plates[::6]
    counted = [len(plate.frequencies_hz(25e3)) / 25.0 for plate in few]
    axes.plot(thickness_mm[::6], counted, "o", color=ORANGE, label="modes counted from 0 to 25 kHz")
    label(axes, "Thickness (mm)", "Characteristic time (ms) = modes per kHz", from_zero=True)
    return figure


def repeated_focus(repetition_s: float = REPETITION_S, n_foci: int = 4) -> Figure:
    """Displacement of the focus under a drive of T that is repeated each T_r (3.19)."""
    figure, (axes,) = sheet(width_in=7.2, height_in=3.2)
    axes.plot(*_train(repetition_s, n_foci), color=BLUE, linewidth=0.6)
    for n in range(n_foci):
        axes.axvline(1e3 * (RIG_BAND.reversal_s + n * repetition_s), color=BLACK, linewidth=0.6, linestyle=":")
    title = f"T = {1e3 * RIG_BAND.reversal_s:g} ms, T_r = {1e3 * repetition_s:g} ms, τ = {1e3 * TAU_S:g} ms"
    label(axes, "Time (ms)", "Displacement (µm)", f"{title}; dotted: foci")
    return figure


def _train(repetition_s: float, n_foci: int) -> tuple[np.ndarray, np.ndarray]:
    """Time (ms) and displacement (um) of the focus."""
    heard = RIG_BAND.responses(A4_PROTOTYPE, [FOCUS])
    once = emitted(RIG_BAND.drive(heard), heard)[0]
    step = round(repetition_s * RIG_BAND.rate_hz)
    u = np.zeros(len(once) + step * (n_foci - 1))
    for start in range(0, step * n_foci, step):
        u[start : start + len(once)] += once
    return np.arange(len(u)) / RIG_BAND.rate_hz * 1e3, 1e6 * u


def time_constants() -> Figure:
    """Reversal time, repetition time and attenuation constant of a train, and what a short T_r costs (3.20)."""
    figure, (train, cost) = sheet(2, 1, width_in=7.2, height_in=6.0)
    t_ms, u_um = _train(REPETITION_S, 2)
    train.plot(t_ms, u_um, color=BLUE, linewidth=0.6)
    first_ms, between_ms, largest_um = 1e3 * RIG_BAND.reversal_s, 1e3 * REPETITION_S, float(u_um.max())
    after_ms = np.linspace(0, between_ms, 100)
    decay_um = 0.2 * largest_um * np.exp(-after_ms / (1e3 * TAU_S))
    train.plot(first_ms + after_ms, decay_um, "--", color=ORANGE, label="exp(−t/τ)")
    for name, start_ms, end_ms in (("T", 0.0, first_ms), ("T_r", first_ms, first_ms + between_ms)):
        height_um, look = 0.7 * largest_um, {"arrowstyle": "<->", "shrinkA": 0, "shrinkB": 0}
        train.annotate("", (start_ms, height_um), (end_ms, height_um), arrowprops=look)
        train.annotate(name, ((start_ms + end_ms) / 2, 0.74 * largest_um), ha="center")
    title = f"T = {first_ms:g} ms, T_r = {between_ms:g} ms, τ = {1e3 * TAU_S:g} ms"
    label(train, "Time (ms)", "Displacement (µm)", title, loc="upper right")
    _train_over_repetition(cost)
    return figure


def _train_over_repetition(axes: Axes) -> None:
    """Amplitude of a repeated focus against T_r."""
    repetition_s = np.linspace(1e-3, 15e-3, 60)
    for taus, colour in ((1.0, ORANGE), (2.0, BLUE), (3.0, BLACK)):
        shares = [repetition_amplitude_ratio(taus * TAU_S, float(t), TAU_S) for t in repetition_s]
        axes.plot(1e3 * repetition_s, 100 * np.array(shares), color=colour, label=f"T = {taus:g} τ")
    label(axes, "Repetition time T_r (ms)", "Amplitude (% of a single focus)", from_zero=True)


def one_sided_layout() -> Figure:
    """Positions of patches on one side, and of foci (4.32, 4.33)."""
    return prototype.layout(one_sided(), FOCI)


def one_sided_resolution() -> Figure:
    """Resolution of each focus of the one-sided layout (4.34)."""
    widths_m = resolution_per_focus_m(one_sided(), FOCI, UNFILTERED)
    expected = Design(A4_SCREEN, Transducers(), UNFILTERED.band, TAU_S, UNFILTERED.reversal_s)
    return prototype.resolution_of_foci(widths_m, expected.resolution_m)
