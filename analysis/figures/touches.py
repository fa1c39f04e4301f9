"""Figure of force or speed around stimulus onset."""

from typing import TYPE_CHECKING, Final

import pandas as pd

from tactometry.palette import COLOURS

from .style import Drawing, drawing_of, grid_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SCALES: Final = {"force_n": (1.0, "N", "Force (N)"), "speed_m_per_s": (1e3, "mm/s", "Speed (mm/s)")}
"""Scale factor, unit and axis label of each quantity."""
N_COLUMNS: Final = 3


def courses_figure(table: pd.DataFrame, quantity: str) -> Drawing:
    """Draw the median, 5th to 95th percentile and target band."""
    rows = table[table["quantity"] == quantity]
    people, targets = sorted(rows["participant"].unique()), sorted(rows["target"].unique())
    with grid_of(len(people), N_COLUMNS, (2.6, 2.1), (1.6, 0.4)) as (figure, grid, left):
        for axes, person in zip(grid, people, strict=True):
            _draw(axes, rows[rows["participant"] == person], quantity, targets)
            axes.set_title(person)
        for axes in left:
            axes.set_ylabel(SCALES[quantity][2])
        for axes in grid[-N_COLUMNS:]:  # the lowest panel of each column
            axes.set_xlabel("Time from onset (s)")
            axes.tick_params(labelbottom=True)
        highest = max(axes.dataLim.y1 for axes in grid)
        grid[0].set_ylim(0.0, 1.1 * highest or 1.0)  # the speed of a resting finger may be 0 throughout
        named = [pair for axes in grid for pair in zip(*axes.get_legend_handles_labels(), strict=True)]
        lines = {text: line for line, text in named}  # list each name once
        figure.legend(lines.values(), lines.keys(), loc="outside right upper")
        return drawing_of(figure)


def _draw(axes: "Axes", rows: pd.DataFrame, quantity: str, targets: list[float]) -> None:
    scale, unit, _ = SCALES[quantity]
    for target, course in rows.groupby("target", sort=True):
        colour = COLOURS[targets.index(float(str(target))) % len(COLOURS)]
        times_s = course["time_s"]
        name = f"{scale * float(str(target)):g} {unit} target"
        axes.fill_between(times_s, scale * course["low"], scale * course["high"], color=colour, alpha=0.2, linewidth=0)
        axes.plot(times_s, scale * course["median"], color=colour, label=name)
        for edge in ("band_low", "band_high"):
            axes.plot(times_s, scale * course[edge], color=colour, linewidth=0.8, linestyle=":")
    axes.axvline(0.0, color="#777777", linewidth=0.8, label="onset")
