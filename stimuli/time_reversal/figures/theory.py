"""Figures of chapter 3 that closed forms draw: resolution, stress, amplitude and contrast."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tactometry.palette import BLACK, BLUE, ORANGE

from ...arrays import FloatArray
from ..design.closed_forms import (
    Reverberation,
    analogue_amplitude_ratio,
    contrast_limit,
    contrast_whole,
    half_wavelength_m,
    one_bit_amplitude_ratio,
    resolution_m,
)
from ..design.guide import STRESS_MAX_PA, Guide, amplitudes_m, contrast_over
from ..design.thickness import Sheet
from ..filters import Band
from ..plate.plate import Plate
from ..plate.statics import bending_stress_pa, deflection_m
from .style import colours, label, sheet

Measured = Sequence[tuple[float, float]]


def resolution_over_bandwidth(plates: Mapping[str, Plate], measured: Mapping[str, Measured] | None = None) -> Figure:
    """Resolution against bandwidth (thesis 3.9, 3.10), with measured points (bandwidth in Hz, width in m) if given."""
    figure, (axes,) = sheet()
    f_max = np.linspace(2e3, 25e3, 60)
    for (name, plate), colour in zip(plates.items(), colours(), strict=False):
        widths = [resolution_m(plate, Band(0.0, float(f))) for f in f_max]
        axes.plot(f_max / 1e3, np.multiply(widths, 1e3), color=colour, label=f"{name}, diffuse-field model")
        _points(axes, (measured or {}).get(name, ()), (1e-3, 1e3), color=colour)
    label(axes, "Bandwidth from 0 (kHz)", "Resolution at −6 dB (mm)", from_zero=True)
    return figure


def resolution_over_mean_frequency(plate: Plate, measured: Measured = ()) -> Figure:
    """Resolution against mean frequency (thesis 3.16, 4.23) with measured points (Hz, m) if given."""
    figure, (axes,) = sheet()
    f = np.linspace(2e3, 60e3, 200)
    axes.plot(f / 1e3, half_wavelength_m(plate, f) * 1e3, color=BLUE, label="half a wavelength")
    widths = [resolution_m(plate, Band(0.0, 2 * float(x))) for x in f[::10]]
    axes.plot(f[::10] / 1e3, np.multiply(widths, 1e3), ".", color=BLACK, label="flat band from 0")
    _points(axes, measured, (1e-3, 1e3), marker="s", color=ORANGE, label="measured")
    label(axes, "Mean frequency (kHz)", "Resolution at −6 dB (mm)", from_zero=True)
    return figure


def stress_and_deflection_over_thickness(plate: Plate, force_n: float = 2.0, contact_m: float = 10e-3) -> Figure:
    """Bending stress and deflection under a force at the centre, against thickness (thesis 3.15), supported edges."""
    thickness = np.linspace(0.4e-3, 3e-3, 40)
    plates = [replace(plate, thickness_m=float(h), boundary="SSSS") for h in thickness]
    middle = (plate.length_m / 2, plate.width_m / 2)
    stress = [bending_stress_pa(one, force_n, contact_m) for one in plates]
    deflection = [deflection_m(one, force_n, middle, *middle)[0] for one in plates]
    figure, (left, right) = sheet(1, 2, width_in=8.0)
    left.semilogy(thickness * 1e3, np.divide(stress, 1e6), color=BLUE)
    right.semilogy(thickness * 1e3, np.multiply(deflection, 1e6), color=ORANGE)
    label(left, "Thickness (mm)", "Largest bending stress (MPa)", f"{force_n:g} N over {contact_m * 1e3:g} mm")
    label(right, "Thickness (mm)", "Largest deflection (µm)", f"{force_n:g} N at the centre")
    return figure


def amplitude_over_reversal(tau_s: float, reversal_s: FloatArray, measured: Measured = ()) -> Figure:
    """Amplitude against reversal time relative to an endless one (thesis 3.18, 4.12), measured (s, share) if given."""
    figure, (axes,) = sheet()
    t = reversal_s * 1e3
    axes.plot(t, one_bit_amplitude_ratio(reversal_s, tau_s) * 100, color=BLUE, label="1 bit, 1 − exp(−T/τ)")
    axes.plot(
        t, analogue_amplitude_ratio(reversal_s, tau_s) * 100, "--", color=ORANGE, label="analogue, 1 − exp(−2T/τ)"
    )
    _points(axes, measured, (1e3, 100), color=BLACK, label="measured")
    axes.axvline(2 * tau_s * 1e3, color=BLACK, linewidth=0.8, linestyle=":")
    axes.annotate(" T = 2τ", (2 * tau_s * 1e3, 5))
    title = f"τ = {tau_s * 1e3:g} ms"
    label(axes, "Reversal time T (ms)", "Amplitude (% of an endless reversal)", title, loc="center right")
    return figure


def contrast_over_transducers(
    room: Reverberation,
    n_channels: Sequence[int],
    reversal_s: FloatArray,
    measured: Mapping[int, Measured] | None = None,
) -> Figure:
    """Contrast against reversal time for numbers of transducers (thesis 3.21, 4.14), measured (s, contrast) by number
    if given."""
    figure, (axes,) = sheet()
    for q, colour in zip(n_channels, colours(), strict=False):
        rooms = [replace(room, n_channels=q, reversal_s=float(t)) for t in reversal_s]
        axes.plot(reversal_s * 1e3, [contrast_whole(one) for one in rooms], color=colour, label=f"Q = {q}")
        _points(axes, (measured or {}).get(q, ()), (1e3, 1), color=colour)
    axes.axhline(contrast_limit(room), color=BLACK, linestyle=":", label="√N, all modes")
    label(axes, "Reversal time T (ms)", "Contrast, A / rms of the plate", from_zero=True, ncols=2)
    return figure


def _points(axes: Axes, measured: Measured, scale: tuple[float, float], **look: Any) -> None:
    if measured:
        axes.plot(*(np.transpose(measured) * np.reshape(scale, (2, 1))), **{"marker": "o", "linestyle": "", **look})


def trade_offs(guide: Guide) -> Figure:
    """Amplitude and contrast over T, contrast over Q, resolution over mean frequency; the recommendation is marked."""
    design = guide.design
    figure, (amplitude, over_t, over_q, resolution) = sheet(2, 2, width_in=8.6, height_in=6.2)
    times = np.linspace(0.1, 4.0, 60) * design.tau_s
    amplitude.plot(times * 1e3, amplitudes_m(design, times) * 1e6, color=BLUE)
    amplitude.plot(design.reversal_s * 1e3, design.amplitude_m * 1e6, "o", color=ORANGE)
    label(amplitude, "Reversal time T (ms)", "Amplitude (µm)")
    counts = np.array([1, 4, 16, design.transducers.n])
    for row, q, colour in zip(contrast_over(design, counts, times), counts, colours(), strict=False):
        over_t.plot(times * 1e3, row, color=colour, label=f"Q = {q}")
    over_t.plot(design.reversal_s * 1e3, design.contrast, "o", color=ORANGE)
    label(over_t, "Reversal time T (ms)", "Contrast, A / rms of the plate", from_zero=True, ncols=2, loc="lower right")
    many = np.unique(np.geomspace(1, 256, 40).astype(int))
    over_q.semilogx(many, contrast_over(design, many, np.array([design.reversal_s]))[:, 0], color=BLUE)
    over_q.plot(design.transducers.n, design.contrast, "o", color=ORANGE)
    over_q.axhline(np.sqrt(design.reverberation.n_modes), color=BLACK, linestyle=":", label="√N, all modes")
    label(over_q, "Number of transducers Q", "Contrast, A / rms of the plate")
    f = np.linspace(2e3, max(60e3, 1.2 * design.band.mean_hz), 100)
    resolution.plot(f / 1e3, half_wavelength_m(design.plate, f) * 1e3, color=BLUE)
    resolution.plot(design.band.mean_hz / 1e3, design.resolution_m * 1e3, "o", color=ORANGE, label="recommended")
    label(resolution, "Mean frequency (kHz)", "Resolution at −6 dB (mm)")
    return figure


def over_thickness(among: Sequence[Sheet], best: Sheet) -> Figure:
    """Resolution, contrast, amplitude and stress of each sheet: hollow where a wish is missed, the best ringed."""
    figure, axes = sheet(2, 2, width_in=8.0, height_in=6.0)
    for one, (name, of) in zip(axes, _QUANTITIES.items(), strict=True):
        for choice in among:
            fill = "none" if choice.unreachable else BLUE
            one.plot(choice.thickness_m * 1e3, of(choice), "o", color=BLUE, markerfacecolor=fill)
            if name in _BY_NUMBER:
                number = f"{choice.guide.design.transducers.n}"
                at = choice.thickness_m * 1e3, of(choice)
                one.annotate(number, at, (0, 8), textcoords="offset points", ha="center", fontsize="x-small")
        one.plot(best.thickness_m * 1e3, of(best), "o", color=ORANGE, fillstyle="none", markersize=12)
        one.set_xscale("log")
        ticks = [choice.thickness_m * 1e3 for choice in among][::2]
        one.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
        one.minorticks_off()
        label(one, "Thickness (mm)", name, from_zero=True)
    axes[-1].axhline(STRESS_MAX_PA / 1e6, color=BLACK, linestyle=":", label="what glass bears for long")
    axes[-1].legend(frameon=False)
    title = (
        "Filled: all wishes met; hollow: not; ringed: recommended; numbers: transducers Q, raised where a wish needs it"
    )
    figure.suptitle(title, fontsize="medium")
    return figure


_BY_NUMBER: Final = ("Contrast, A / rms of the plate", "Amplitude (µm)")
"""What more transducers raise."""

_QUANTITIES: Final[Mapping[str, Callable[[Sheet], float]]] = {
    "Resolution at −6 dB (mm)": lambda choice: choice.guide.design.resolution_m * 1e3,
    "Contrast, A / rms of the plate": lambda choice: choice.guide.design.contrast,
    "Amplitude (µm)": lambda choice: choice.guide.design.amplitude_m * 1e6,
    "Bending stress at 2 N (MPa)": lambda choice: choice.stress_pa / 1e6,
}
