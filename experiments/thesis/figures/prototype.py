"""Figures of the prototype and the force-loss study."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from tactometry.palette import BLACK, BLUE, ORANGE
from tactometry.stimuli.arrays import FloatArray
from tactometry.stimuli.time_reversal.figures.style import ABOVE, colours, label, sheet
from tactometry.stimuli.time_reversal.finger import LossRow
from tactometry.stimuli.time_reversal.responses.responses import Point
from tactometry.stimuli.time_reversal.screen.screen import Screen
from tactometry.stimuli.time_reversal.screen.transducer import Patch


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
