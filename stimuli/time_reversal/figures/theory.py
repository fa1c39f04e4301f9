"""Figures of chapter 3 from closed forms."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import cycle
from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tactometry.palette import BLACK, BLUE, GOLD, GREEN, ORANGE, PINK, SKY

from ..design.closed_forms import half_wavelength_m
from ..design.guide import STRESS_MAX_PA, Guide, amplitudes_m, contrast_over
from ..design.thickness import Sheet

COLOURS: Final = (BLUE, ORANGE, GREEN, PINK, SKY, GOLD, BLACK)
DIVERGING: Final = "RdBu_r"
RESOLUTION_DPI: Final = 150
ABOVE: Final[Mapping[str, Any]] = {"loc": "lower center", "bbox_to_anchor": (0.5, 1.0)}
"""Position of a legend above its axes."""


def sheet(
    n_rows: int = 1, n_columns: int = 1, *, width_in: float = 6.4, height_in: float = 4.0
) -> tuple[Figure, list[Axes]]:
    """Return a figure and its axes, row by row."""
    figure = Figure(figsize=(width_in, height_in), layout="constrained")
    return figure, list(figure.subplots(n_rows, n_columns, squeeze=False).ravel())


def label(axes: Axes, x: str, y: str, title: str = "", *, from_zero: bool = False, **legend: Any) -> None:
    """Label the axes with units, and draw a light grid and a legend."""
    axes.set(xlabel=x, ylabel=y)
    if from_zero:
        axes.set_ylim(0, 1.05 * axes.dataLim.y1)  # else values far above 0 touch the upper edge
    if axes.get_legend_handles_labels()[0]:
        axes.legend(frameon=False, **legend)
    axes.set_title(title, fontsize="medium")
    axes.grid(alpha=0.3)
    axes.spines[["top", "right"]].set_visible(False)


def colours() -> Iterator[str]:
    """Repeat the palette endlessly."""
    return cycle(COLOURS)


def save(figure: Figure, path: Path) -> None:
    """Write a figure in the format of the file's suffix."""
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=RESOLUTION_DPI)


def trade_offs(guide: Guide) -> Figure:
    """Plot amplitude, contrast and resolution with the recommendation."""
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
    """Plot each sheet's numbers, hollow where a target is missed."""
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
    axes[-1].axhline(STRESS_MAX_PA / 1e6, color=BLACK, linestyle=":", label="permanent limit of glass")
    axes[-1].legend(frameon=False)
    title = (
        "Filled: all targets met; hollow: not; ringed: recommended; numbers: transducers Q, raised if a target needs it"
    )
    figure.suptitle(title, fontsize="medium")
    return figure


_BY_NUMBER: Final = ("Contrast, A / rms of the plate", "Amplitude (µm)")
"""Quantities that more transducers increase."""

_QUANTITIES: Final[Mapping[str, Callable[[Sheet], float]]] = {
    "Resolution at −6 dB (mm)": lambda choice: choice.guide.design.resolution_m * 1e3,
    "Contrast, A / rms of the plate": lambda choice: choice.guide.design.contrast,
    "Amplitude (µm)": lambda choice: choice.guide.design.amplitude_m * 1e6,
    "Bending stress at 2 N (MPa)": lambda choice: choice.stress_pa / 1e6,
}
