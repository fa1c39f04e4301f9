"""Figures of calibrations."""

from pathlib import Path

import numpy as np

from tactometry.palette import BLUE, ORANGE
from tactometry.stimuli.time_reversal.figures.theory import label, save, sheet
from tactometry.stimuli.time_reversal.responses.responses import Responses

from .calibration import ForceFit


def force_figure(fit: ForceFit, path: Path) -> None:
    """Plot force over counts, with the fit and its residuals."""
    figure, (above, below) = sheet(2, 1, height_in=5.5)
    counts = np.linspace(fit.counts.min(), fit.counts.max(), 200)
    above.plot(counts, np.polynomial.polynomial.polyval(counts, fit.polynomial), color=BLUE, label="fit")
    above.plot(fit.counts, fit.forces_n, "o", color=ORANGE, label="weights")
    label(above, "sensor (counts)", "force (N)", f"polynomial of degree {len(fit.polynomial) - 1}")
    below.axhline(0, color=BLUE)
    below.plot(fit.counts, 1e3 * fit.residuals_n, "o", color=ORANGE)
    label(below, "sensor (counts)", "residual (mN)", f"rms {1e3 * fit.residual_rms_n:.3g} mN")
    save(figure, path)


def responses_figure(responses: Responses, path: Path) -> None:
    """Plot the first learned response over time, and all spectra."""
    figure, (above, below) = sheet(2, 1, height_in=5.5)
    unit = {"displacement": "m/V", "velocity": "m/s/V", "acceleration": "m/s²/V"}[responses.quantity]
    times_s = np.arange(responses.n_samples) / responses.rate_hz
    above.plot(1e3 * times_s, responses.samples[0, 0], color=BLUE, linewidth=0.7)
    label(above, "time (ms)", f"response ({unit} per sample)", "channel 1")
    spectra = np.abs(np.fft.rfft(responses.samples[0])).T
    frequency_khz = np.fft.rfftfreq(responses.n_samples, 1 / responses.rate_hz) / 1e3
    below.semilogy(frequency_khz[1:], spectra[1:], color=ORANGE, linewidth=0.5, alpha=0.6)
    label(below, "frequency (kHz)", f"{responses.quantity} ({unit})", f"{responses.n_channels} channels")
    save(figure, path)
