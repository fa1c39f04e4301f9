"""Figure of measurements: loss of amplitude over conditions."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from .axes import FactorAxis, place, series
from .style import Drawing, drawn, house_style, look, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def loss_figure(group: pd.DataFrame, factors: Sequence[str]) -> Drawing:
    """Mean loss (%) with its interval against the main factor (force): a panel per level of the factor with the fewest
    (place), a line per condition of the others (contactor)."""
    axis = FactorAxis.of(group, factors)
    panel_by = min(axis.series, key=lambda name: group[name].nunique()) if len(axis.series) > 1 else None
    panels = series(group, [panel_by] if panel_by else [])
    lines = [name for name in axis.series if name != panel_by]
    with house_style():
        figure = new_figure(2.9 * len(panels) + 1.6, 3.2)
        grid = figure.subplots(1, len(panels), squeeze=False, sharey=True)[0]
        for axes, (name, panel) in zip(grid, panels, strict=True):
            _draw_panel(axes, panel, axis, lines)
            axes.set_title("" if panel_by is None else f"{panel_by} {name}")
        grid[0].set_ylim(min(0.0, grid[0].get_ylim()[0]), None)
        grid[0].set_ylabel("Amplitude loss (%)")
        if lines:
            figure.legend(*grid[0].get_legend_handles_labels(), loc="outside right center")
        return drawn(figure)


def _draw_panel(axes: "Axes", panel: pd.DataFrame, axis: FactorAxis, lines: Sequence[str]) -> None:
    where = place(axes, panel[axis.along] if axis.along else ["all"], axis.along)
    for n, (name, part) in enumerate(series(panel, lines)):
        x = [where[v] for v in (part[axis.along] if axis.along else ["all"] * len(part))]
        mean, low, high = (100 * part[column].astype(float).to_numpy() for column in ("mean", "mean_low", "mean_high"))
        ends = np.nan_to_num(np.stack([mean - low, high - mean]), nan=0.0)
        axes.errorbar(x, mean, yerr=ends, label=name, capsize=2.5, elinewidth=1.0, **look(n))
