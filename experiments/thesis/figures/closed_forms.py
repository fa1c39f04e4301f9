"""Closed-form figures of chapter 3."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure

from tactometry.palette import BLACK, BLUE, ORANGE
from tactometry.stimuli.arrays import FloatArray
from tactometry.stimuli.time_reversal.design.closed_forms import (
    Reverberation,
    analogue_amplitude_ratio,
    contrast_limit,
    contrast_whole,
    half_wavelength_m,
    one_bit_amplitude_ratio,
    resolution_m,
)
from tactometry.stimuli.time_reversal.figures.style import colours, label, sheet
from tactometry.stimuli.time_reversal.filters import Band
from tactometry.stimuli.time_reversal.plate.plate import Plate
from tactometry.stimuli.time_reversal.plate.statics import bending_stress_pa, deflection_m


def resolution_over_bandwidth(plates: Mapping[str, Plate]) -> Figure:
    """Plot resolution against bandwidth (thesis 3.9, 3.10)."""
    figure, (axes,) = sheet()
    f_max = np.linspace(2e3, 25e3, 60)
    for (name, plate), colour in zip(plates.items(), colours(), strict=False):
        widths = [resolution_m(plate, Band(0.0, float(f))) for f in f_max]
        axes.plot(f_max / 1e3, np.multiply(widths, 1e3), color=colour, label=f"{name}, diffuse-field model")
    label(axes, "Bandwidth from 0 (kHz)", "Resolution at −6 dB (mm)", from_zero=True)
    return figure


def resolution_over_mean_frequency(plate: Plate) -> Figure:
    """Plot resolution against mean frequency (thesis 3.16, 4.23)."""
    figure, (axes,) = sheet()
    f = np.linspace(2e3, 60e3, 200)
    axes.plot(f / 1e3, half_wavelength_m(plate, f) * 1e3, color=BLUE, label="half a wavelength")
    widths = [resolution_m(plate, Band(0.0, 2 * float(x))) for x in f[::10]]
    axes.plot(f[::10] / 1e3, np.multiply(widths, 1e3), ".", color=BLACK, label="flat band from 0")
    label(axes, "Mean frequency (kHz)", "Resolution at −6 dB (mm)", from_zero=True)
    return figure


def stress_and_deflection_over_thickness(plate: Plate, force_n: float = 2.0, contact_m: float = 10e-3) -> Figure:
    """Plot bending stress and deflection against thickness (thesis 3.15)."""
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


def amplitude_over_reversal(tau_s: float, reversal_s: FloatArray) -> Figure:
    """Plot amplitude against reversal time (thesis 3.18, 4.12)."""
    figure, (axes,) = sheet()
    t = reversal_s * 1e3
    axes.plot(t, one_bit_amplitude_ratio(reversal_s, tau_s) * 100, color=BLUE, label="1 bit, 1 − exp(−T/τ)")
    axes.plot(
        t, analogue_amplitude_ratio(reversal_s, tau_s) * 100, "--", color=ORANGE, label="analogue, 1 − exp(−2T/τ)"
    )
    axes.axvline(2 * tau_s * 1e3, color=BLACK, linewidth=0.8, linestyle=":")
    axes.annotate(" T = 2τ", (2 * tau_s * 1e3, 5))
    title = f"τ = {tau_s * 1e3:g} ms"
    label(axes, "Reversal time T (ms)", "Amplitude (% of an endless reversal)", title, loc="center right")
    return figure


def contrast_over_transducers(
    room: Reverberation,
    n_channels: Sequence[int],
    reversal_s: FloatArray,
) -> Figure:
    """Plot contrast against reversal time (thesis 3.21, 4.14)."""
    figure, (axes,) = sheet()
    for q, colour in zip(n_channels, colours(), strict=False):
        rooms = [replace(room, n_channels=q, reversal_s=float(t)) for t in reversal_s]
        axes.plot(reversal_s * 1e3, [contrast_whole(one) for one in rooms], color=colour, label=f"Q = {q}")
    axes.axhline(contrast_limit(room), color=BLACK, linestyle=":", label="√N, all modes")
    label(axes, "Reversal time T (ms)", "Contrast, A / rms of the plate", from_zero=True, ncols=2)
    return figure
