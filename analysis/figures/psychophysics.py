"""Figures of tracks, means, rates and magnitudes by level, and losses."""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from ..anova.group_means import HIGH, LOW
from ..tasks.kinds import CURVES
from ..wording import with_unit
from .style import (
    SPREAD,
    Drawing,
    FactorAxis,
    bars,
    drawing_of,
    look,
    means_with_intervals,
    new_figure,
    panels,
    series,
    shift,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def track_figure(rows: pd.DataFrame, factors: Sequence[str], *, unit: str) -> Drawing:
    """Draw tracks; filled markers are "yes" or correct answers."""
    axis = FactorAxis.of(rows, factors)
    labels = "Trial within the track", with_unit("Level", unit)
    return panels(rows, axis, partial(_draw_tracks, axis=axis), labels=labels, height_in=2.1, share_x=False)


def _draw_tracks(axes: "Axes", panel: pd.DataFrame, axis: FactorAxis) -> None:
    tracks = [name for name in (axis.along, "track", "session") if name and name in panel.columns]
    for name, line, colour in axis.lines(panel):
        for place, (_, track) in enumerate(line.groupby(tracks) if tracks else [("", line)]):
            x = np.arange(1, len(track) + 1)
            up = track["yes"].to_numpy() == 1
            level = track["level"].to_numpy()
            axes.plot(x, level, "-", color=colour, linewidth=0.9, label=name if place == 0 else None)
            axes.plot(x[up], level[up], "o", color=colour, markersize=2.2)
            axes.plot(x[~up], level[~up], "o", color=colour, markersize=2.6, mfc="white", mew=0.7)


BESIDE = 0.4
"""Offset of the participants' dots, as a fraction of the step to the next series."""
ROOM = 1.05
"""Upper margin of an axis that begins at 0."""
MOST_INSIDE = 4
"""Largest number of series with the legend inside the axes."""
OPEN = {"mfc": "none", "alpha": 0.8}
RATES = (-0.03, 1.03)
"""Range of an axis of rates, with a margin for dots at 0 and 1."""


def threshold_figure(
    group: pd.DataFrame,
    individuals: pd.DataFrame,
    factors: Sequence[str],
    dependent: str,
    label: str,
    *,
    targets: Sequence[float] = (),
    from_zero: bool = False,
) -> Drawing:
    """Draw means with intervals against the main factor, one line per series.

    Participants are faint dots, or open triangles if only a bound is known. `targets` are dashed lines. With
    `from_zero` the axis of values begins at 0.
    """
    axis = FactorAxis.of(group, factors)
    with new_figure(6.6, 3.6) as figure:
        axes = figure.add_subplot()
        where = axis.place(axes, group)
        lines, log = series(group, axis.series), axes.get_xscale() == "log"
        for n, (name, line) in enumerate(lines):
            x = axis.x(line, shift(n, len(lines), where, log=log))
            means_with_intervals(axes, x, line, label=name, **look(n))
        for n, (_, line) in enumerate(series(individuals, axis.series)):
            beside = shift(n + BESIDE, len(lines), where, log=log)
            _draw_individuals(axes, line, axis, beside, dependent, look(n)["color"])
        for target in targets:
            axes.axhline(target, color="#777777", linestyle="--", linewidth=0.8, zorder=0)
        axes.set_ylabel(label)
        if from_zero:
            low, high = axes.get_ylim()
            axes.set_ylim(min(0.0, low), ROOM * high)
        _legend(axes, len(lines) if axis.series else 0, beside=len(targets) > 0)
        return drawing_of(figure)


def _legend(axes: "Axes", n: int, *, beside: bool = False) -> None:
    """Add a legend of `n` series, inside the axes if there are few."""
    if n > MOST_INSIDE or (n and beside):
        axes.get_figure().legend(loc="outside right center")  # type: ignore[union-attr]
    elif n:
        axes.legend(loc="best")


def _draw_individuals(
    axes: "Axes", values: pd.DataFrame, axis: FactorAxis, where: Mapping[object, float], dependent: str, colour: str
) -> None:
    kinds: tuple[tuple[str, dict[str, Any]], ...] = (
        (dependent, {"marker": ".", "alpha": 0.6}),
        (LOW, {"marker": "^"} | OPEN),
        (HIGH, {"marker": "v"} | OPEN),
    )
    for column, style in kinds:
        if column in values.columns:
            held = values[values[column].notna()]
            x, y = axis.x(held, where), held[column].astype(float)
            axes.plot(x, y, linestyle="", color=colour, markersize=4, zorder=1, **style)


def rate_figure(rates: pd.DataFrame, factors: Sequence[str], *, unit: str) -> Drawing:
    """Draw rates against level: a panel per series."""
    labels = with_unit("Level", unit), CURVES[str(rates["task"].iloc[0])].rate_label
    return _level_figure(rates, factors, "rate", labels, 2.5, ylim=RATES)


def growth_figure(growth: pd.DataFrame, factors: Sequence[str], *, unit: str) -> Drawing:
    """Draw geometric means of magnitudes against level on logarithmic axes."""
    labels = with_unit("Level", unit), "Magnitude (geometric mean)"
    of_levels = "linear" if unit.startswith("dB") else "log"
    return _level_figure(growth, factors, "geometric_mean", labels, 2.7, yscale="log", xscale=of_levels)


def _level_figure(
    table: pd.DataFrame, factors: Sequence[str], column: str, labels: tuple[str, str], height_in: float, **scales: Any
) -> Drawing:
    """Draw a column against level; `scales` sets limits and scales of axes."""
    axis = FactorAxis.of(table, factors)

    def draw(axes: "Axes", panel: pd.DataFrame) -> None:
        for name, line, colour in axis.lines(panel):
            axes.plot(line["level"], line[column], "o-", color=colour, label=name, markersize=3)
        axes.set(**scales)

    return panels(table, axis, draw, labels=labels, height_in=height_in, share_x=True)


def mean_rate_figure(rates: pd.DataFrame, factors: Sequence[str]) -> Drawing:
    """Draw the mean rate over all levels against the main factor."""
    axis = FactorAxis.of(rates, factors)
    with new_figure(6.6, 3.0) as figure:
        axes = figure.add_subplot()
        where, lines = axis.place(axes, rates), series(rates, axis.series)
        for n, (name, line) in enumerate(lines):
            axes.plot(axis.x(line, where), line["rate"], label=name, **look(n))
        axes.set_ylabel(CURVES[str(rates["task"].iloc[0])].rate_label + ", all levels")
        axes.set_ylim(*RATES)
        _legend(axes, len(lines) if axis.series else 0)
        return drawing_of(figure)


def loss_figure(group: pd.DataFrame, factors: Sequence[str]) -> Drawing:
    """Draw the mean loss (%) against the main factor.

    Each level of the factor with the fewest levels has a panel.
    """
    axis = FactorAxis.of(group, factors)
    panel_by = min(axis.series, key=lambda name: group[name].nunique()) if len(axis.series) > 1 else None
    places = series(group, [panel_by] if panel_by else [])
    lines = [name for name in axis.series if name != panel_by]
    with new_figure(2.9 * len(places) + 1.6, 3.2) as figure:
        grid = figure.subplots(1, len(places), squeeze=False, sharey=True)[0]
        for axes, (name, panel) in zip(grid, places, strict=True):
            _draw_losses(axes, panel, axis, lines)
            axes.set_title("" if panel_by is None else f"{panel_by} {name}")
        grid[0].set_ylim(min(0.0, grid[0].get_ylim()[0]), None)
        grid[0].set_ylabel("Amplitude loss (%)")
        if lines:
            figure.legend(*grid[0].get_legend_handles_labels(), loc="outside right center")
        return drawing_of(figure)


def _draw_losses(axes: "Axes", panel: pd.DataFrame, axis: FactorAxis, lines: Sequence[str]) -> None:
    where = axis.place(axes, panel)
    for n, (name, line) in enumerate(series(panel, lines)):
        mean, reach = (100 * values for values in bars(line, "mean"))
        reach = np.nan_to_num(reach, nan=0.0)
        axes.errorbar(axis.x(line, where), mean, yerr=reach, label=name, capsize=2.5, elinewidth=1.0, **look(n))


CHANCE = 0.5
EDGE = 0.02
"""Axis range with a margin for dots at 0 and 1."""


def share_figure(shares: pd.DataFrame, items: Sequence[str]) -> Drawing:
    """Draw how often each item was preferred, with intervals."""
    lines = series(shares, list(shares.columns[: shares.columns.get_loc("item")]))
    with new_figure(5.4, (0.3 + 0.1 * len(lines)) * len(items) + 0.9) as figure:
        axes = figure.add_subplot()
        for n, (name, rows) in enumerate(lines):
            share, reach = bars(rows.set_index("item").reindex(list(items)), "share")
            y = np.arange(len(items)) + min(SPREAD, SPREAD * 4 / len(lines)) * (n - (len(lines) - 1) / 2)
            style: dict[str, Any] = {"capsize": 2.5, "elinewidth": 1.0, "linestyle": "none"} | look(n)
            axes.errorbar(share, y, xerr=reach, label=name, **style)
        axes.axvline(CHANCE, color="#777777", linestyle=":", linewidth=0.9, zorder=0)
        axes.set_yticks(range(len(items)), list(items))
        axes.set(xlabel="Share of its pairs won", xlim=(-EDGE, 1 + EDGE), ylim=(len(items) - 0.5, -0.5))
        if len(lines) > 1:
            figure.legend(loc="outside right center")
        return drawing_of(figure)
