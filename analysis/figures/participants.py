"""Figures of one participant: psychometric curves and tracks."""

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from statsmodels.stats.proportion import proportion_confint

from ..tasks.cells import Estimate
from ..tasks.kinds import CURVES
from ..threshold.status import Status
from ..wording import condition_name, with_unit
from .style import Drawing, FactorAxis, drawing_of, look, new_figure, panels

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MAX_PANELS = 36
"""A participant's figure shows no more conditions than this."""


def curve_figure(estimates: Sequence[Estimate], factors: Sequence[str], *, unit: str) -> Drawing:
    """One participant: in each condition the rate at each level with Wilson's 95 % interval, the fitted
    curve, and the threshold with its interval as a bar at the bottom."""
    shown = list(estimates)[:MAX_PANELS]
    columns = min(7, len(shown)) if len(shown) > 8 else min(4, len(shown))
    rows = -(-len(shown) // columns)
    levels = [x for estimate in shown for x in estimate.cell.levels] or [0.0, 1.0]
    span = (min(levels), max(levels)) if min(levels) < max(levels) else (min(levels) - 1, max(levels) + 1)
    with new_figure(max(1.45 * columns, 3.0), 1.35 * rows + 0.5) as figure:
        for place, estimate in enumerate(shown):
            axes = _panel(figure, place, rows, columns)
            _draw_curve(axes, estimate, span)
            axes.set_title(condition_name(factors, estimate.cell.condition), fontsize=7, pad=2)
            axes.tick_params(
                labelsize=6.5, length=2, labelleft=place % columns == 0, labelbottom=place >= len(shown) - columns
            )
        task = shown[0].cell.task
        figure.supxlabel(with_unit("Level", unit), fontsize=8)
        figure.supylabel(CURVES[task].rate_label, fontsize=8, x=0.08 / figure.get_size_inches()[0])
        return drawing_of(figure)


def _panel(figure: Any, place: int, rows: int, columns: int) -> "Axes":
    """A panel at a fixed spot: laying out dozens of panels takes longer than drawing them."""
    figure.set_layout_engine("none")
    width_in, height_in = figure.get_size_inches()
    left, bottom = 0.62 / width_in, 0.45 / height_in
    across, up = (1 - left - 0.01) / columns, (1 - bottom - 0.02) / rows
    column, row = place % columns, rows - 1 - place // columns
    axes: Axes = figure.add_axes((left + column * across, bottom + row * up, across * 0.9, up * 0.76))
    return axes


def _draw_curve(axes: "Axes", estimate: Estimate, span: tuple[float, float]) -> None:
    cell, fit = estimate.cell, estimate.fit
    k, n = np.array(cell.n_yes), np.array(cell.n_trials)
    if len(n):
        low, high = proportion_confint(k, n, method="wilson")
        axes.vlines(cell.levels, low, high, color="#888888", linewidth=0.8)
        axes.scatter(cell.levels, k / n, s=3 + 14 * n / n.max(), color=look(0)["color"], linewidths=0, zorder=3)
    if fit.function is not None:
        x = np.linspace(*span, 80)
        axes.plot(x, fit.function.probability(x), color=look(1)["color"], linewidth=1.1)
    ends = [span[0] if fit.interval_low is None else fit.interval_low]
    ends.append(span[1] if fit.interval_high is None else fit.interval_high)
    if (fit.interval_low, fit.interval_high) != (None, None):
        axes.plot(ends, [-0.06, -0.06], color=look(1)["color"], linewidth=2, solid_capstyle="butt")
    if fit.threshold is not None:
        axes.plot([fit.threshold], [-0.06], "|", color="black", markersize=5)
    if fit.status != Status.OK:
        axes.text(0.04, 0.93, str(fit.status).replace("threshold_", "").replace("_", " "), fontsize=6, va="top",
                  transform=axes.transAxes, color=look(1)["color"])  # fmt: skip
    axes.set_ylim(-0.12, 1.05)
    margin = 0.04 * (span[1] - span[0])
    axes.set_xlim(span[0] - margin, span[1] + margin)
    axes.set_yticks([0, 0.5, 1])


def track_figure(rows: pd.DataFrame, factors: Sequence[str], *, unit: str) -> Drawing:
    """Staircases of one participant: level against trial, a panel per series (force), a line per value of the
    main factor (frequency); filled where the answer was yes or correct, open where not, catch trials left
    out."""
    axis = FactorAxis.of(rows, factors)
    labels = "Trial of the track", with_unit("Level", unit)
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
