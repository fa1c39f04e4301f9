"""Figures of a focus and of the four driving signals."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from tactometry.palette import BLACK, BLUE, ORANGE
from tactometry.stimuli.arrays import FloatArray
from tactometry.stimuli.time_reversal.figures.theory import ABOVE, DIVERGING, colours, label, sheet
from tactometry.stimuli.time_reversal.filters import Band
from tactometry.stimuli.time_reversal.finger import LossRow
from tactometry.stimuli.time_reversal.focusing.focusing import Emission, drive, emitted, focus_amplitude
from tactometry.stimuli.time_reversal.focusing.merit import Grid, field, grid, width_m
from tactometry.stimuli.time_reversal.focusing.modulator import modulate
from tactometry.stimuli.time_reversal.focusing.pattern import PATTERNS, Pattern
from tactometry.stimuli.time_reversal.focusing.sound import NoiseSpectrum
from tactometry.stimuli.time_reversal.responses.measured import schroeder_db, tau_s
from tactometry.stimuli.time_reversal.responses.responses import Point, Responses
from tactometry.stimuli.time_reversal.screen.screen import Screen
from tactometry.stimuli.time_reversal.screen.transducer import VOLTAGE_V, Patch

N_X, N_Y = 301, 213


def displacement_map(screen: Screen, focus: Point, emission: Emission) -> Figure:
    """Plot the plate at the focus instant (thesis 3.8)."""
    figure, (left, right) = sheet(1, 2, width_in=9.6, height_in=3.4)
    x, y = grid(screen, N_X, N_Y)
    at_focus = _focus_instant(screen, focus, emission)
    _map(figure, left, (x, y), at_focus, "Focus instant")
    line = at_focus((x, np.array([focus[1]])))[:, 0]
    right.plot(x * 1e3, line * 1e6, color=BLUE)
    near = np.abs(x - focus[0]) < 0.25 * screen.plate.length_m
    title = f"y = {focus[1] * 1e3:g} mm, width {width_m(x[near], line[near]) * 1e3:.1f} mm"
    label(right, "x (mm)", "Displacement (µm)", title)
    return figure


def scans_per_band(screen: Screen, focus: Point, bands: Sequence[Band], emission: Emission) -> Figure:
    """Plot the focus for several bands (thesis 3.13)."""
    figure, axes = sheet(1, len(bands), width_in=3.4 * len(bands), height_in=2.8)
    for one, band in zip(axes, bands, strict=True):
        within = replace(emission, band=band)
        title = f"{band.f_min_hz / 1e3:g}–{band.f_max_hz / 1e3:g} kHz"
        _map(figure, one, grid(screen, N_X, N_Y), _focus_instant(screen, focus, within), title)
    return figure


def amplitude_over_bandwidth(screens: Mapping[str, Screen], focus: Point, emission: Emission) -> Figure:
    """Plot focus amplitude against bandwidth (thesis 3.11, 3.12)."""
    figure, (axes,) = sheet()
    widths = np.linspace(2e3, emission.band.f_max_hz, 12)
    for (name, screen), colour in zip(screens.items(), colours(), strict=False):
        amplitude = [_amplitude(screen, focus, replace(emission, band=Band(0.0, float(b)))) for b in widths]
        axes.plot(widths / 1e3, np.multiply(amplitude, 1e6), "o-", color=colour, label=name)
    label(axes, "Bandwidth from 0 (kHz)", "Focus amplitude (µm)", from_zero=True)
    return figure


def frequency_response(responses: Responses, f_max_hz: float, voltage_v: float = VOLTAGE_V) -> Figure:
    """Plot the response spectrum and the focus amplitude (thesis 3.14)."""
    figure, (axes,) = sheet(width_in=7.2, height_in=3.2)
    f = np.fft.rfftfreq(responses.n_samples, 1 / responses.rate_hz)
    power = np.mean(np.abs(np.fft.rfft(responses.samples[0])) ** 2, axis=0)
    shown = (f > 0) & (f <= f_max_hz)
    axes.plot(f[shown] / 1e3, 10 * np.log10(power[shown] / power[shown].max()), color=BLUE, linewidth=0.8)
    amplitude_m = focus_amplitude(drive(responses, voltage_v), responses)
    title = f"Focus of {amplitude_m * 1e6:.2g} µm at {voltage_v:g} V, 1 bit"
    label(axes, "Frequency (kHz)", "Mean response (dB re largest)", title)
    return figure


def decay_fit(response: FloatArray, rate_hz: float) -> Figure:
    """Plot an impulse response with an exponential decay (thesis 4.11)."""
    fitted = tau_s(response, rate_hz)
    time_ms = np.arange(len(response)) / rate_hz * 1e3
    figure, (left, right) = sheet(1, 2, width_in=9.0, height_in=3.4)
    left.plot(time_ms, response / np.abs(response).max(), color=BLUE, linewidth=0.5)
    for sign in (1, -1):
        left.plot(time_ms, sign * np.exp(-time_ms / fitted / 1e3), color=ORANGE)
    label(left, "Time (ms)", "Response (of its largest)", f"τ = {fitted * 1e3:.2f} ms")
    level = schroeder_db(response)
    right.plot(time_ms, level, color=BLUE, label="energy to come")
    right.plot(time_ms, -20 / np.log(10) * time_ms / fitted / 1e3, "--", color=ORANGE, label="fitted slope")
    right.set_ylim(-40, 1)
    label(right, "Time (ms)", "Level (dB)")
    return figure


def noise_window(
    screen: Screen, focus: Point, emission: Emission, window_s: tuple[float, float] = (1e-3, 4e-3)
) -> Figure:
    """Plot the time signal at the focus (thesis 4.13)."""
    time_ms, u = _course(screen, focus, emission)
    figure, (axes,) = sheet(width_in=7.2, height_in=3.2)
    axes.plot(time_ms, u, color=BLUE, linewidth=0.6)
    axes.axvspan(window_s[0] * 1e3, window_s[1] * 1e3, color=ORANGE, alpha=0.25, label="noise window")
    peak = u[np.argmin(np.abs(time_ms))]
    axes.annotate(f"A = {peak:.2f} µm", (0.0, peak), xytext=(6, -4), textcoords="offset points")
    label(axes, "Time from the focus (ms)", "Displacement (µm)", loc="lower right")
    return figure


def four_signals(screen: Screen, focus: Point, emissions: Mapping[str, Emission]) -> Figure:
    """Plot the focus in time and space per signal (thesis 4.15 to 4.22)."""
    figure, axes = sheet(2, len(emissions), width_in=3.0 * len(emissions), height_in=5.0)
    for i, (name, emission) in enumerate(emissions.items()):
        _focus_in_time(axes[i], screen, focus, emission, name)
        _focus_in_space(axes[len(emissions) + i], screen, focus, emission)
    for row in (axes[: len(emissions)], axes[len(emissions) :]):
        for one in row[1:]:
            one.set_ylabel("")
    return figure


def _focus_in_time(axes: Axes, screen: Screen, focus: Point, emission: Emission, name: str) -> None:
    time_ms, u = _course(screen, focus, emission)
    shown = np.abs(time_ms) < 0.5
    axes.plot(time_ms[shown], u[shown], color=BLUE, linewidth=0.9)
    label(axes, "Time (ms)", "Displacement (µm)", name)


def _focus_in_space(axes: Axes, screen: Screen, focus: Point, emission: Emission) -> None:
    x = np.linspace(max(focus[0] - 0.05, 0), min(focus[0] + 0.05, screen.plate.length_m), 301)
    u = _focus_instant(screen, focus, emission)((x, np.array([focus[1]])))[:, 0] * 1e6
    axes.plot((x - focus[0]) * 1e3, u, color=ORANGE, linewidth=0.9)
    label(axes, "x from the focus (mm)", "Displacement (µm)", f"width {width_m(x, u) * 1e3:.1f} mm")


def _course(screen: Screen, focus: Point, emission: Emission) -> tuple[FloatArray, FloatArray]:
    """Return times from the focus instant (ms) and displacement (um)."""
    responses = emission.responses(screen, [focus])
    signal = emission.drive(responses)
    u = emitted(signal, responses)[0] * 1e6
    return (np.arange(len(u)) - signal.samples.shape[1] + 1) / emission.rate_hz * 1e3, u


def _focus_instant(screen: Screen, focus: Point, emission: Emission) -> Callable[[Grid], FloatArray]:
    signal = emission.drive(emission.responses(screen, [focus]))
    last = signal.samples.shape[1] - 1
    return lambda at_m: field(screen, signal, last, at_m, emission.f_max_hz)


def _amplitude(screen: Screen, focus: Point, emission: Emission) -> float:
    responses = emission.responses(screen, [focus])
    return focus_amplitude(emission.drive(responses), responses)


def _map(figure: Figure, axes: Axes, at_m: Grid, displacement: Callable[[Grid], FloatArray], title: str) -> None:
    (x, y), u = at_m, displacement(at_m)
    largest = float(np.abs(u).max()) * 1e6
    extent = (0, x[-1] * 1e3, 0, y[-1] * 1e3)
    image = axes.imshow(u.T * 1e6, origin="lower", extent=extent, cmap=DIVERGING, vmin=-largest, vmax=largest)
    figure.colorbar(image, ax=axes, label="Displacement (µm)", shrink=0.85)
    axes.set(xlabel="x (mm)", ylabel="y (mm)")
    axes.set_title(title, fontsize="medium")


def modulator_noise(rate_hz: float = 1e6, f_max_hz: float = 25e3, n_samples: int = 1 << 18) -> Figure:
    """Plot the spectral density of quantisation noise (thesis 4.9)."""
    from scipy.signal import welch

    rng = np.random.default_rng(0)
    signal = 0.5 * np.sin(2 * np.pi * 3e3 * np.arange(n_samples) / rate_hz) + rng.uniform(-0.1, 0.1, n_samples)
    figure, (axes,) = sheet()
    streams = {"1 bit": np.sign(signal), **{f"order {k}": modulate(signal[None], k).bits[0] for k in (1, 2)}}
    for (name, bits), colour in zip(streams.items(), colours(), strict=False):
        f, density = welch(bits - signal, rate_hz, nperseg=8192)
        shown = (f > 0) & (f <= f_max_hz)
        axes.plot(f[shown] / 1e3, 10 * np.log10(density[shown]), color=colour, linewidth=0.8, label=name)
    f = np.linspace(200.0, f_max_hz, 300)
    for order in (1, 2):
        shaped = 2 / (3 * rate_hz) * (2 * np.sin(np.pi * f / rate_hz)) ** (2 * order)
        axes.plot(f / 1e3, 10 * np.log10(shaped), ":", color=BLACK, label="white error, shaped" if order == 1 else None)
    label(axes, "Frequency (kHz)", "Noise density (dB re V²/Hz)", ncols=2, loc="lower right")
    return figure


def sound_spectra(spectra: Mapping[str, NoiseSpectrum], f_max_hz: float = 125e3) -> Figure:
    """Plot sound pressure spectra of driving signals (thesis 4.25 to 4.27)."""
    figure, axes = sheet(2, (len(spectra) + 1) // 2, width_in=8.6, height_in=5.4)
    for one, (name, spectrum) in zip(axes, spectra.items(), strict=False):
        # bands of 500 Hz; samples above the last band are not drawn
        n_bands = int(min(f_max_hz, spectrum.frequency_hz[-1]) / 500.0)
        bands = (spectrum.frequency_hz / 500.0).astype(int)
        mean = np.array([spectrum.pressure_pa2_per_hz[bands == n].mean() for n in range(n_bands)])
        middles_hz = np.asarray(500.0 * np.arange(0.5, n_bands), float)
        level = NoiseSpectrum(middles_hz, mean).level_db_re_20upa
        one.plot(middles_hz / 1e3, level, color=BLUE, linewidth=0.8)
        one.axvspan(0, 20, color=ORANGE, alpha=0.15)
        one.set_ylim(-40, 70)
        title = f"{name}: {spectrum.a_weighted_db:.0f} dBA; shaded: audible"
        label(one, "Frequency (kHz)", "dB re 20 µPa/√Hz", title)
    return figure


def pattern_waveforms(patterns: Mapping[str, Pattern] = PATTERNS) -> Figure:
    """Plot times and amplitudes of the foci of each pattern (thesis 5.8)."""
    figure, axes = sheet(len(patterns), 1, width_in=6.4, height_in=1.1 * len(patterns) + 0.6)
    for one, (name, pattern) in zip(axes, patterns.items(), strict=True):
        one.vlines(pattern.times_s * 1e3, 0, pattern.weights, color=BLUE)
        one.plot(pattern.times_s * 1e3, pattern.weights, "o", color=BLUE, markersize=3)
        one.axhline(0, color=BLACK, linewidth=0.6)
        one.set(xlim=(-2, 52), ylim=(-0.4, 1.15))
        label(one, "Time (ms)" if one is axes[-1] else "", f"{name}", "")
    figure.supylabel("Focus amplitude (of P0)", fontsize="medium")
    return figure


def layout(screen: Screen, foci: Sequence[Point]) -> Figure:
    """Plot positions of transducers and foci (thesis 4.28)."""
    figure, (axes,) = sheet(width_in=6.8, height_in=5.0)
    axes.add_patch(Rectangle((0, 0), screen.plate.length_m * 1e3, screen.plate.width_m * 1e3, fill=False))
    patches = [source for source in screen.sources if isinstance(source, Patch)]
    for number, patch in enumerate(patches):
        corner = ((patch.x_m - patch.length_m / 2) * 1e3, (patch.y_m - patch.width_m / 2) * 1e3)
        axes.add_patch(Rectangle(corner, patch.length_m * 1e3, patch.width_m * 1e3, color=BLUE, alpha=0.5))
        axes.text(patch.x_m * 1e3, patch.y_m * 1e3, str(number + 1), ha="center", va="center", fontsize=6)
    axes.plot(*(np.array(foci).T * 1e3), "x", color=ORANGE, label="foci")
    axes.set_aspect("equal")
    axes.set(xlim=(-5, screen.plate.length_m * 1e3 + 5), ylim=(-5, screen.plate.width_m * 1e3 + 5))
    axes.set(xlabel="x (mm)", ylabel="y (mm)")
    axes.legend(frameon=False, **ABOVE)
    return figure


def amplitude_per_transducer(contributions_m: FloatArray) -> Figure:
    """Plot the mean amplitude of each transducer alone (thesis 4.29)."""
    figure, (axes,) = sheet(width_in=7.2, height_in=3.2)
    number = np.arange(1, contributions_m.shape[1] + 1)
    mean, spread = contributions_m.mean(axis=0) * 1e6, contributions_m.std(axis=0, ddof=1) * 1e6
    axes.bar(number, mean, yerr=spread, color=BLUE, ecolor=BLACK, capsize=2)
    label(axes, "Transducer", "Mean amplitude (µm)", "Bars: mean over foci; lines: ± one standard deviation")
    return figure


def amplitude_over_count(amplitudes_m: FloatArray) -> Figure:
    """Plot amplitude against the number of transducers (thesis 4.30).

    Amplitudes have the shape (n_draws, n_points, n_channels).
    """
    figure, (axes,) = sheet()
    number = np.arange(1, amplitudes_m.shape[2] + 1)
    low, middle, high = np.percentile(amplitudes_m, [5, 50, 95], axis=(0, 1)) * 1e6
    axes.fill_between(number, low, high, color=BLUE, alpha=0.25, label="5 to 95 % of foci and draws")
    axes.plot(number, middle, color=BLUE, label="median")
    label(axes, "Number of transducers Q", "Focus amplitude (µm)")
    return figure


def amplitude_by_subset(amplitudes_m: Mapping[str, FloatArray]) -> Figure:
    """Plot amplitude of each focus by transducer subset (thesis 4.31)."""
    figure, (axes,) = sheet(width_in=7.2)
    for (name, values), colour, marker in zip(amplitudes_m.items(), colours(), "osD^v<>", strict=False):
        axes.plot(np.arange(1, len(values) + 1), values * 1e6, marker, color=colour, label=name)
    label(axes, "Focus", "Amplitude (µm)", from_zero=True, ncols=len(amplitudes_m), **ABOVE)
    return figure


def resolution_of_foci(widths_m: FloatArray, expected_m: float) -> Figure:
    """Plot the resolution of each focus along x and y (thesis 4.34)."""
    figure, (axes,) = sheet(width_in=7.2)
    number = np.arange(1, len(widths_m) + 1)
    axes.plot(number, widths_m[:, 0] * 1e3, "o", color=BLUE, label="along x")
    axes.plot(number, widths_m[:, 1] * 1e3, "s", color=ORANGE, label="along y")
    axes.axhline(expected_m * 1e3, color=BLACK, linestyle=":", label="model")
    label(axes, "Focus", "Width at −6 dB (mm)", from_zero=True, ncols=3, **ABOVE)
    return figure


def loss_over_force(rows: Sequence[LossRow], measured: Sequence[LossRow] = ()) -> Figure:
    """Plot amplitude loss against force, a panel per place (5.4, 5.5)."""
    places = list(dict.fromkeys(row.place for row in rows))
    figure, axes = sheet(1, len(places), width_in=4.6 * len(places) + 1.0, height_in=3.8)
    for one, place in zip(axes, places, strict=True):
        label(one, "Contact force (N)", "Amplitude loss (%)", f"Contact at {place}")
        kinds = dict.fromkeys((row.contactor, row.diameter_m) for row in rows if row.place == place)
        for kind, colour, marker in zip(kinds, colours(), "osD^v<>", strict=False):
            name = kind[0] if kind[0] == "finger" else f"{kind[0]}, {kind[1] * 1e3:g} mm"
            one.plot(*_points(rows, kind, place), f"{marker}-", color=colour, label=name)
            if any((row.contactor, row.diameter_m) == kind for row in measured):
                points = _points(measured, kind, place)
                one.plot(*points, marker, color=colour, fillstyle="none", label=f"{name}, measured")
        one.set_ylim(0, None)
    figure.legend(*axes[0].get_legend_handles_labels(), frameon=False, loc="outside right center")
    return figure


def _points(rows: Sequence[LossRow], kind: tuple[str, float], place: str) -> tuple[list[float], list[float]]:
    """Return forces (N) and losses (%) of a contactor at a place."""
    chosen = [row for row in rows if (row.contactor, row.diameter_m) == kind and row.place == place]
    return [row.force_n for row in chosen], [100 * row.loss for row in chosen]
