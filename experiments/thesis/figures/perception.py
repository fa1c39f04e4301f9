"""Figures of chapters 5 and 6: how often something is felt, and how it is liked, by simulated participants."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from tactometry.palette import BLUE, ORANGE
from tactometry.stimuli.time_reversal.figures.style import colours, label, sheet

Curve = tuple[Sequence[float], Sequence[float]]


def detection_rate(curves: Mapping[str, Curve], x_label: str, title: str = "", *, logarithmic: bool = False) -> Figure:
    """Mean detection rate (of 1) against amplitude or frequency, a curve per condition (5.7, 6.15)."""
    figure, (axes,) = sheet()
    for (name, (x, rates)), colour, marker, size in zip(
        curves.items(), colours(), "osD^v<>", (11, 8, 5, 4, 4, 4, 4), strict=False
    ):  # curves that coincide show through each other
        axes.plot(x, np.multiply(100, rates), f"{marker}-", color=colour, markersize=size, label=name)
    if logarithmic:
        ticks = next(iter(curves.values()))[0]
        axes.set_xscale("log")
        axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
        axes.minorticks_off()
    axes.set_ylim(-3, 103)
    label(axes, x_label, "Mean detection rate (%)", title)
    return figure


def liking(scores: Mapping[str, float], title: str) -> Figure:
    """Pleasantness of each pattern, the single focus first (5.9 to 5.13)."""
    figure, (axes,) = sheet(width_in=7.2)
    tints = [ORANGE if n == 0 else BLUE for n in range(len(scores))]
    axes.bar(range(len(scores)), list(scores.values()), color=tints)
    axes.set_xticks(range(len(scores)), [name.replace(", ", "\n") for name in scores], fontsize="small")
    axes.axhline(0, color="0.3", linewidth=0.8)
    axes.set_ylim(-1, 1)
    label(axes, "", "Pleasantness (−1 to 1)", title)
    return figure
