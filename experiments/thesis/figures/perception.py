"""Figures of chapters 5 and 6: how often simulated participants feel something, and with which force they touch it."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from tactometry.stimuli.time_reversal.figures.style import colours, label, sheet

Curve = tuple[Sequence[float], Sequence[float]]
BIN_N = 0.04


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


def applied_forces(by_asked: Mapping[float, Sequence[float]]) -> Figure:
    """How often each force (N) was applied, a curve per force that was asked for (6.13)."""
    figure, (axes,) = sheet(width_in=7.2)
    for (asked_n, forces_n), colour in zip(by_asked.items(), colours(), strict=False):
        shares, edges_n = np.histogram(forces_n, BIN_N * np.arange(np.ceil(1.3 * asked_n / BIN_N) + 1))
        middles_n = (edges_n[:-1] + edges_n[1:]) / 2
        axes.plot(middles_n, 100 * shares / len(forces_n), color=colour, drawstyle="steps-mid", label=f"{asked_n:g} N")
        axes.axvline(asked_n, color=colour, linestyle="--", linewidth=0.8)
    label(axes, "Mean applied force of a trial (N)", "Trials of the condition (%)", "Dashed: asked", from_zero=True)
    return figure
