"""Figures of localisation: rate correct by distance, and confusions."""

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from ..wording import percent_text
from .style import Drawing, bars, drawing_of, grid_of, look, new_figure, series

if TYPE_CHECKING:
    from matplotlib.axes import Axes

DISTANCE = "separation_m"
DISTANCE_IN_MM = "distance_mm"
MM = 1e3
MOST_PANELS = 12
"""With more conditions, the answers of all conditions are pooled."""
N_COLUMNS = 4
BELOW = 0.06
"""Distance between the bars of the resolutions below the axis."""
DARK = 0.55
"""Larger shares are written in white."""


def distance_figure(rates: pd.DataFrame, resolutions: pd.DataFrame, chance: float) -> Drawing:
    """Draw the rate correct against distance (mm), with resolutions below."""
    keys = list(rates.columns[: rates.columns.get_loc(DISTANCE)])
    with new_figure(5.4, 3.4) as figure:
        axes = figure.add_subplot()
        for n, (name, line) in enumerate(series(rates, keys)):
            rate, reach = bars(line, "rate")
            axes.errorbar(MM * line[DISTANCE], rate, yerr=reach, label=name, capsize=2.5, elinewidth=1.0, **look(n))
        lines = series(resolutions, keys) if len(resolutions) else []
        for n, (_, row) in enumerate(lines):
            _draw_resolution(axes, row.iloc[0], -BELOW * (n + 1), look(n)["color"])
        axes.axhline(chance, color="#777777", linestyle=":", linewidth=0.9, zorder=0)
        axes.set(xlabel="Distance between the nearest two places (mm)", ylabel="Right answers", xlim=(0, None))
        axes.set_ylim(-BELOW * (len(lines) + 1), 1.03)
        if keys:
            figure.legend(loc="outside right center")
        return drawing_of(figure)


def _draw_resolution(axes: "Axes", row: "pd.Series[float]", height: float, colour: str) -> None:
    if pd.notna(row["mean_low"]) and pd.notna(row["mean_high"]):
        ends = [MM * row["mean_low"], MM * row["mean_high"]]
        axes.plot(ends, [height, height], color=colour, linewidth=2, solid_capstyle="butt")
    if pd.notna(row["mean"]):
        axes.plot([MM * row["mean"]], [height], "|", color="black", markersize=7)


def confusion_figure(confusions: pd.DataFrame) -> Drawing:
    """Draw confusion matrices, a panel per condition and distance."""
    keys = list(confusions.columns[: confusions.columns.get_loc("right_place")])
    in_mm = confusions.assign(**{name: MM * confusions[name] for name in keys if name == DISTANCE})
    renamed = in_mm.rename(columns={DISTANCE: DISTANCE_IN_MM})
    parts = series(renamed, list(renamed.columns[: len(keys)]))
    panels = parts if len(parts) <= MOST_PANELS else [("all conditions", confusions)]
    places = list(dict.fromkeys([*confusions["right_place"], *sorted(confusions["answered_place"])]))
    with grid_of(len(panels), N_COLUMNS, (1.75, 1.75), (1.2, 0.9)) as (figure, grid, _):
        for axes, (name, panel) in zip(grid, panels, strict=True):
            _draw_matrix(axes, panel, places)
            axes.set_title(name, fontsize=8)
        for axes in grid[-N_COLUMNS:]:  # only the lowest panel of each column
            axes.tick_params(labelbottom=True)
        figure.supxlabel("Answered place", fontsize=9)
        figure.supylabel("Right place", fontsize=9)
        return drawing_of(figure)


def _draw_matrix(axes: "Axes", panel: pd.DataFrame, places: list[str]) -> None:
    counts = panel.pivot_table(index="right_place", columns="answered_place", values="n", aggfunc="sum")
    table = counts.reindex(index=places, columns=places).fillna(0).to_numpy(float)
    total = table.sum(axis=1, keepdims=True)
    share = np.divide(table, total, out=np.zeros_like(table), where=total > 0)
    axes.imshow(share, cmap="Blues", vmin=0, vmax=1)
    for (row, column), value in np.ndenumerate(share):
        text = percent_text(value).removesuffix(" %")
        axes.text(column, row, text, ha="center", va="center", fontsize=7, color="white" if value > DARK else "black")
    axes.set_xticks(range(len(places)), places, rotation=45, ha="right", fontsize=7)
    axes.set_yticks(range(len(places)), places, fontsize=7)
