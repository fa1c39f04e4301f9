"""Figures of a group: thresholds, and rates against level."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from tactometry.analysis.figures.axes import RATE_LABEL, Axis, panels, place, series, shift
from tactometry.analysis.style import Drawing, drawn, house_style, look, new_figure, shades

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def threshold_figure(
    group: pd.DataFrame,
    factors: Sequence[str],
    *,
    label: str,
    individuals: pd.DataFrame,
    dependent: str,
    targets: Sequence[float] = (),
) -> Drawing:
    """Mean over participants with its 95 % interval against the main factor, a line per series; bounds as
    arrows, single participants as faint dots, `targets` as dashed lines."""
    axis = Axis.of(group, factors)
    with house_style():
        figure = new_figure(6.6, 3.6)
        axes = figure.add_subplot()
        where = place(axes, group[axis.along] if axis.along else ["all"], axis.along)
        parts = series(group, axis.series)
        for n, (name, part) in enumerate(parts):
            moved = shift(n, len(parts), where, log=axes.get_xscale() == "log")
            _draw_means(axes, part, axis, moved, name, n)
        _draw_individuals(axes, individuals, axis, where, dependent)
        for target in targets:
            axes.axhline(target, color="#777777", linestyle="--", linewidth=0.8, zorder=0)
        axes.set_ylabel(label)
        if axis.series:
            axes.legend(loc="best", title=None)
        return drawn(figure)


def _draw_means(
    axes: "Axes", part: pd.DataFrame, axis: Axis, where: dict[object, float], name: str, n_series: int
) -> None:
    style = look(n_series)
    x = np.array([where[v] for v in (part[axis.along] if axis.along else ["all"] * len(part))])
    mean, low, high = (part[column].astype(float).to_numpy() for column in ("mean", "mean_low", "mean_high"))
    told = np.isfinite(mean)
    ends = np.nan_to_num(np.stack([mean - low, high - mean])[:, told], nan=0.0)
    axes.errorbar(x[told], mean[told], yerr=ends, label=name, capsize=2.5, elinewidth=1.0, **style)
    for bound, marker in ((low, "^"), (high, "v")):
        only = ~told & np.isfinite(bound)
        axes.plot(x[only], bound[only], marker, mfc="none", color=style["color"], markersize=7)


def _draw_individuals(
    axes: "Axes", individuals: pd.DataFrame, axis: Axis, where: dict[object, float], dependent: str
) -> None:
    for n, (_, part) in enumerate(series(individuals, axis.series)):
        told = part[part[dependent].notna()]
        x = [where[v] for v in (told[axis.along] if axis.along else ["all"] * len(told))]
        axes.plot(x, told[dependent].astype(float), ".", color=look(n)["color"], alpha=0.6, markersize=4, zorder=1)


def rate_figure(rates: pd.DataFrame, factors: Sequence[str], *, unit: str) -> Drawing:
    """Detection rate against level, one panel per series (force), one line per value of the main factor
    (frequency)."""
    axis = Axis.of(rates, factors)

    def draw(axes: "Axes", panel: pd.DataFrame) -> None:
        lines = series(panel, [axis.along] if axis.along else [])
        for (line, part), colour in zip(lines, shades(len(lines)), strict=True):
            axes.plot(part["level"], part["rate"], "-", color=colour, label=line, marker="o", markersize=3)
        axes.set_ylim(-0.03, 1.03)

    labels = f"Level ({unit})" if unit else "Level", RATE_LABEL[str(rates["task"].iloc[0])]
    return panels(rates, axis, draw, labels=labels, height_in=2.5, share_x=True)


def mean_rate_figure(rates: pd.DataFrame, factors: Sequence[str]) -> Drawing:
    """Mean detection rate (all levels) against the main factor, a line per series."""
    axis = Axis.of(rates, factors)
    with house_style():
        figure = new_figure(6.6, 3.0)
        axes = figure.add_subplot()
        where = place(axes, rates[axis.along] if axis.along else ["all"], axis.along)
        for n, (name, part) in enumerate(series(rates, axis.series)):
            x = [where[v] for v in (part[axis.along] if axis.along else ["all"])]
            axes.plot(x, part["rate"], label=name, **look(n))
        axes.set_ylabel(RATE_LABEL[str(rates["task"].iloc[0])] + ", all levels")
        axes.set_ylim(-0.03, 1.03)
        if axis.series:
            axes.legend(loc="best")
        return drawn(figure)
