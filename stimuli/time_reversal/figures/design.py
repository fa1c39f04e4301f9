"""The trade-offs behind a recommendation of `tactometry design` (thesis 3.22)."""

import numpy as np
from matplotlib.figure import Figure

from tactometry.stimuli.time_reversal.closed_forms import half_wavelength_m
from tactometry.stimuli.time_reversal.design import Guide, amplitude_over_reversal, contrast_over
from tactometry.stimuli.time_reversal.figures.style import BLACK, BLUE, ORANGE, colours, label, sheet


def trade_offs(guide: Guide) -> Figure:
    """Amplitude and contrast over T, contrast over Q, resolution over mean frequency; the recommendation is marked."""
    design = guide.design
    figure, (amplitude, over_t, over_q, resolution) = sheet(2, 2, width_in=8.6, height_in=6.2)
    times = np.linspace(0.1, 4.0, 60) * design.tau_s
    amplitude.plot(times * 1e3, amplitude_over_reversal(design, times) * 1e6, color=BLUE)
    amplitude.plot(design.reversal_s * 1e3, design.amplitude_m * 1e6, "o", color=ORANGE)
    label(amplitude, "Reversal time T (ms)", "Amplitude (µm)")
    counts = np.array([1, 4, 16, design.transducers.n])
    for row, q, colour in zip(contrast_over(design, counts, times), counts, colours(), strict=False):
        over_t.plot(times * 1e3, row, color=colour, label=f"Q = {q}")
    over_t.plot(design.reversal_s * 1e3, design.contrast, "o", color=ORANGE)
    label(over_t, "Reversal time T (ms)", "Contrast, A / rms of the plate")
    over_t.set_ylim(0, None)
    over_t.legend(frameon=False, ncols=2, loc="lower right")
    many = np.unique(np.geomspace(1, 256, 40).astype(int))
    over_q.semilogx(many, contrast_over(design, many, np.array([design.reversal_s]))[:, 0], color=BLUE)
    over_q.plot(design.transducers.n, design.contrast, "o", color=ORANGE)
    over_q.axhline(np.sqrt(design.reverberation.n_modes), color=BLACK, linestyle=":", label="√N, all modes")
    over_q.legend(frameon=False)
    label(over_q, "Number of transducers Q", "Contrast, A / rms of the plate")
    f = np.linspace(2e3, max(60e3, 1.2 * design.band.mean_hz), 100)
    resolution.plot(f / 1e3, half_wavelength_m(design.plate, f) * 1e3, color=BLUE)
    resolution.plot(design.band.mean_hz / 1e3, design.resolution_m * 1e3, "o", color=ORANGE, label="recommended")
    resolution.legend(frameon=False)
    label(resolution, "Mean frequency (kHz)", "Resolution at −6 dB (mm)")
    return figure
