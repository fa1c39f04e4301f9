"""Figures of driving signals: quantisation, modulators and their noise, sound."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch

from tactometry.palette import BLACK, BLUE, ORANGE

from ...arrays import FloatArray
from ..field.sound import NoiseSpectrum
from ..focusing.modulator import modulate
from ..focusing.one_bit import OneBit
from ..focusing.pattern import PATTERNS, Pattern
from ..focusing.pulse_width import PulseWidth
from ..focusing.quantiser import Quantiser
from ..focusing.sigma_delta import SigmaDelta
from .style import colours, label, sheet


def quantised_sine(rate_hz: float = 1e6, frequency_hz: float = 5e3) -> Figure:
    """A sine and its 1-bit, PWM and sigma-delta streams (thesis 4.5, 4.6)."""
    t = np.arange(round(2 * rate_hz / frequency_hz)) / rate_hz
    sine = 0.7 * np.sin(2 * np.pi * frequency_hz * t)
    rules: dict[str, Quantiser] = {
        "1 bit": OneBit(),
        "PWM, 60 kHz": PulseWidth(60e3, 0.7),
        "Sigma-delta, order 1": SigmaDelta(1, 0.7),
        "Sigma-delta, order 2": SigmaDelta(2, 0.7),
    }
    figure, axes = sheet(4, 1, width_in=7.2, height_in=6.0)
    for one, (name, rule), colour in zip(axes, rules.items(), colours(), strict=False):
        one.step(t * 1e3, rule.quantise(sine[None], rate_hz)[0], where="post", color=colour, linewidth=0.6)
        one.plot(t * 1e3, sine, color=BLACK, linewidth=1.2)
        label(one, "Time (ms)" if one is axes[-1] else "", "Signal / V", name)
    return figure


def modulator_noise(rate_hz: float = 1e6, f_max_hz: float = 25e3, n_samples: int = 1 << 18) -> Figure:
    """Spectral density of what quantisation adds, 0 to 25 kHz, with the transfer functions (thesis 4.9)."""
    rng = np.random.default_rng(0)
    signal = 0.5 * np.sin(2 * np.pi * 3e3 * np.arange(n_samples) / rate_hz) + rng.uniform(-0.1, 0.1, n_samples)
    figure, (axes,) = sheet()
    streams = {"1 bit": np.sign(signal), **{f"order {k}": modulate(signal[None], k).bits[0] for k in (1, 2)}}
    for (name, bits), colour in zip(streams.items(), colours(), strict=False):
        f, density = _density(bits - signal, rate_hz)
        shown = (f > 0) & (f <= f_max_hz)
        axes.plot(f[shown] / 1e3, 10 * np.log10(density[shown]), color=colour, linewidth=0.8, label=name)
    f = np.linspace(200.0, f_max_hz, 300)
    for order in (1, 2):
        shaped = 2 / (3 * rate_hz) * (2 * np.sin(np.pi * f / rate_hz)) ** (2 * order)
        axes.plot(f / 1e3, 10 * np.log10(shaped), ":", color=BLACK, label="white error, shaped" if order == 1 else None)
    label(axes, "Frequency (kHz)", "Noise density (dB re V²/Hz)", ncols=2, loc="lower right")
    return figure


def modulator_diagram(order: int) -> Figure:
    """Block diagram of the error-feedback modulator (thesis 4.7, 4.8)."""
    figure, (axes,) = sheet(width_in=7.2, height_in=3.0)
    axes.set(xlim=(0, 10), ylim=(0, 4))
    axes.axis("off")
    for x, y, text in ((2.0, 3.2, "u − ·"), (5.5, 3.2, "sign"), (5.5, 1.9, "v − y"), (2.0, 0.6, _FEEDBACK[order])):
        axes.add_patch(FancyBboxPatch((x - 0.8, y - 0.3), 1.6, 0.6, boxstyle="round,pad=0.05", fc="white", ec=BLACK))
        axes.text(x, y, text, ha="center", va="center")
    for start, *middle, end in _WIRES:
        corners = [start, *middle]
        axes.plot(*zip(*corners, strict=True), color=BLACK, linewidth=1.2)
        axes.add_patch(
            FancyArrowPatch(corners[-1], end, arrowstyle="-|>", mutation_scale=10, color=BLACK, shrinkA=0, shrinkB=0)
        )
    for x, y, text in ((0.5, 3.35, "u"), (3.7, 3.35, "y"), (9.2, 3.35, "v"), (4.6, 0.7, "e")):
        axes.text(x, y, text, style="italic", ha="center")
    axes.set_title(f"Sigma-delta modulator of order {order}", fontsize="medium")
    return figure


_FEEDBACK = {1: "z⁻¹", 2: "2z⁻¹ − z⁻²"}
_WIRES: tuple[tuple[tuple[float, float], ...], ...] = (
    ((0.2, 3.2), (1.15, 3.2)),
    ((2.85, 3.2), (4.65, 3.2)),
    ((6.35, 3.2), (9.7, 3.2)),
    ((3.7, 3.2), (3.7, 1.9), (4.65, 1.9)),
    ((7.4, 3.2), (7.4, 1.9), (6.35, 1.9)),
    ((5.5, 1.55), (5.5, 0.6), (2.85, 0.6)),
    ((2.0, 0.95), (2.0, 2.85)),
)


def sound_spectra(spectra: Mapping[str, NoiseSpectrum], f_max_hz: float = 125e3) -> Figure:
    """Sound pressure spectra of driving signals, 0 to 125 kHz (thesis 4.25 to 4.27), with the A-weighted levels."""
    figure, axes = sheet(2, (len(spectra) + 1) // 2, width_in=8.6, height_in=5.4)
    for one, (name, spectrum) in zip(axes, spectra.items(), strict=False):
        f, level = _smoothed(spectrum, f_max_hz)
        one.plot(f / 1e3, level, color=BLUE, linewidth=0.8)
        one.axvspan(0, 20, color=ORANGE, alpha=0.15)
        one.set_ylim(-40, 70)
        title = f"{name}: {spectrum.a_weighted_db:.0f} dBA; shaded: audible"
        label(one, "Frequency (kHz)", "dB re 20 µPa/√Hz", title)
    return figure


def pattern_waveforms(patterns: Mapping[str, Pattern] = PATTERNS) -> Figure:
    """When the foci of each pattern come, and how large (thesis 5.8)."""
    figure, axes = sheet(len(patterns), 1, width_in=6.4, height_in=1.1 * len(patterns) + 0.6)
    for one, (name, pattern) in zip(axes, patterns.items(), strict=True):
        one.vlines(pattern.times_s * 1e3, 0, pattern.weights, color=BLUE)
        one.plot(pattern.times_s * 1e3, pattern.weights, "o", color=BLUE, markersize=3)
        one.axhline(0, color=BLACK, linewidth=0.6)
        one.set(xlim=(-2, 52), ylim=(-0.4, 1.15))
        label(one, "Time (ms)" if one is axes[-1] else "", f"{name}", "")
    figure.supylabel("Focus amplitude (of P0)", fontsize="medium")
    return figure


def _density(noise: FloatArray, rate_hz: float) -> tuple[FloatArray, FloatArray]:
    from scipy.signal import welch

    f, density = welch(noise, rate_hz, nperseg=8192)
    return np.asarray(f), np.asarray(density)


def _smoothed(spectrum: NoiseSpectrum, f_max_hz: float, width_hz: float = 500.0) -> tuple[FloatArray, FloatArray]:
    n_bands = int(min(f_max_hz, spectrum.frequency_hz[-1]) / width_hz)
    bands = (spectrum.frequency_hz / width_hz).astype(int)  # what lies above the last is drawn nowhere
    mean = np.array([spectrum.pressure_pa2_per_hz[bands == n].mean() for n in range(n_bands)])
    middles_hz = np.asarray(width_hz * np.arange(0.5, n_bands), float)
    return middles_hz, NoiseSpectrum(middles_hz, mean).level_db_re_20upa
