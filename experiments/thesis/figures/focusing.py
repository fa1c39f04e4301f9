"""Figures of chapters 3 and 4 that the gallery of time reversal does not have."""

import numpy as np
from matplotlib.figure import Figure

from tactometry.palette import BLACK, BLUE, ORANGE
from tactometry.stimuli.time_reversal import Attenuation, emitted
from tactometry.stimuli.time_reversal.design.closed_forms import repetition_amplitude_ratio
from tactometry.stimuli.time_reversal.design.guide import Design, Transducers
from tactometry.stimuli.time_reversal.field.merit import resolution_per_focus_m
from tactometry.stimuli.time_reversal.figures import prototype
from tactometry.stimuli.time_reversal.figures.gallery import FOCI, FOCUS, RIG_BAND, UNFILTERED
from tactometry.stimuli.time_reversal.figures.style import label, sheet
from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN, BOROFLOAT_33
from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE, TAU_S, Screen
from tactometry.stimuli.time_reversal.screen.transducer import SIDE_M, Patch

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


def repeated_focus(repetition_s: float = 10e-3, n_foci: int = 4) -> Figure:
    """Displacement of the focus under a drive of T that is repeated each T_r (3.19, 3.20)."""
    heard = RIG_BAND.responses(A4_PROTOTYPE, [FOCUS])
    once = emitted(RIG_BAND.drive(heard), heard)[0]
    step = round(repetition_s * RIG_BAND.rate_hz)
    u = np.zeros(len(once) + step * (n_foci - 1))
    for start in range(0, step * n_foci, step):
        u[start : start + len(once)] += once
    t_ms = np.arange(len(u)) / RIG_BAND.rate_hz * 1e3
    figure, (axes,) = sheet(width_in=7.2, height_in=3.2)
    axes.plot(t_ms, 1e6 * u, color=BLUE, linewidth=0.6)
    for n in range(n_foci):
        axes.axvline(1e3 * (RIG_BAND.reversal_s + n * repetition_s), color=BLACK, linewidth=0.6, linestyle=":")
    title = f"T = {1e3 * RIG_BAND.reversal_s:g} ms, T_r = {1e3 * repetition_s:g} ms, τ = {1e3 * TAU_S:g} ms"
    label(axes, "Time (ms)", "Displacement (µm)", f"{title}; dotted: foci")
    return figure


def train_over_repetition() -> Figure:
    """Amplitude of a repeated focus against T_r (3.20)."""
    figure, (axes,) = sheet()
    repetition_s = np.linspace(1e-3, 15e-3, 60)
    for taus, colour in ((1.0, ORANGE), (2.0, BLUE), (3.0, BLACK)):
        shares = [repetition_amplitude_ratio(taus * TAU_S, float(t), TAU_S) for t in repetition_s]
        axes.plot(1e3 * repetition_s, 100 * np.array(shares), color=colour, label=f"T = {taus:g} τ")
    label(
        axes, "Repetition time T_r (ms)", "Amplitude (% of a single focus)", f"τ = {1e3 * TAU_S:g} ms", from_zero=True
    )
    return figure


def one_sided_layout() -> Figure:
    """Positions of patches on one side, and of foci (4.32, 4.33)."""
    return prototype.layout(one_sided(), FOCI)


def one_sided_resolution() -> Figure:
    """Resolution of each focus of the one-sided layout (4.34)."""
    widths_m = resolution_per_focus_m(one_sided(), FOCI, UNFILTERED)
    expected = Design(A4_SCREEN, Transducers(), UNFILTERED.band, TAU_S, UNFILTERED.reversal_s)
    return prototype.resolution_of_foci(widths_m, expected.resolution_m)
