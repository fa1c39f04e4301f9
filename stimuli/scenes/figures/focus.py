"""What a screen does at a focus: the map and its middle in mm and µm, the courses and their middle in time."""

from itertools import cycle
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure

from ...time_reversal.field.merit import HALF, area_m2
from ..result import Result
from .courses import COLOURS, PANEL_IN, draw_course, mark, names, numbers

WIDTH_IN, MAP_IN, HEAD_IN, AXIS_IN = 10.0, 3.6, 0.5, 0.3
SLIDING_TIME = "sliding_t_s"
NEAR_M, NEAR_S = 15e-3, 0.25e-3
AROUND = 1.5
DIVERGING = "RdBu_r"


def focus_sheet(result: Result, title: str) -> Figure:
    """The map, its middle and all courses; single numbers in the title."""
    values = result.values
    drawn = names(values) if "t_s" in values else []
    slid = names(values, SLIDING_TIME) if SLIDING_TIME in values else []
    said = numbers(values)
    lines = [title, *(";  ".join(said[n : n + 3]) for n in range(0, len(said), 3))]
    head_in = HEAD_IN * (1 + len(lines) / 3)
    heights = [MAP_IN, *(PANEL_IN * len(part) + AXIS_IN for part in (drawn, slid) if part)]
    figure = Figure(figsize=(WIDTH_IN, sum(heights) + head_in), layout="constrained")
    above, *below = figure.subfigures(len(heights), 1, height_ratios=heights, squeeze=False)[:, 0]
    _maps(above, values)
    sheets = [(draw, outputs) for draw, outputs in ((_courses, drawn), (_sliding_courses, slid)) if outputs]
    for below_map, (draw, outputs) in zip(below, sheets, strict=True):
        draw(below_map, result, outputs)
    figure.suptitle("\n".join(lines), fontsize="medium")
    return figure


def _maps(figure: SubFigure, values: Any) -> None:
    x_m, y_m, field_m = values["x_m"], values["y_m"], values["field_m"]
    whole, near = figure.subplots(1, 2, width_ratios=(1.5, 1))
    peak = np.unravel_index(np.abs(field_m).argmax(), field_m.shape)
    image = draw_map(whole, x_m, y_m, field_m, float(np.abs(field_m).max()))
    draw_map(near, x_m, y_m, field_m, float(np.abs(field_m).max()))
    near.contour(x_m * 1e3, y_m * 1e3, field_m.T / field_m[peak], levels=[HALF], colors="k", linewidths=1.0)
    half_m2 = area_m2(field_m, (x_m, y_m)) if field_m.any() else 0.0
    reach_m = max(NEAR_M, AROUND * (half_m2 / np.pi) ** 0.5)
    for axis, at_m, limit in (("x", x_m[peak[0]], near.set_xlim), ("y", y_m[peak[1]], near.set_ylim)):
        limit((at_m - reach_m) * 1e3, (at_m + reach_m) * 1e3)
        near.set(**{f"{axis}label": f"{axis} (mm)"})
    whole.set_title("focus instant", fontsize="small")
    near.set_title(f"line: half of the peak, {half_m2 * 1e6:.0f} mm²", fontsize="small")
    figure.colorbar(image, ax=near, label="displacement (µm)", shrink=0.9)


def draw_map(axes: Axes, x_m: Any, y_m: Any, field_m: Any, largest_m: float) -> Any:
    """A field in µm over mm; 0 is white."""
    extent = (x_m[0] * 1e3, x_m[-1] * 1e3, y_m[0] * 1e3, y_m[-1] * 1e3)
    shown = field_m.T * 1e6
    largest = largest_m * 1e6
    image = axes.imshow(shown, origin="lower", extent=extent, cmap=DIVERGING, vmin=-largest, vmax=largest)
    axes.set(xlabel="x (mm)", ylabel="y (mm)")
    return image


def _courses(figure: SubFigure, result: Result, drawn: list[str]) -> None:
    values = result.values
    panels = figure.subplots(len(drawn), 2, squeeze=False, width_ratios=(2, 1), sharex="col")
    for row, name, colour in zip(panels, drawn, cycle(COLOURS), strict=False):
        for panel in row:
            draw_course(panel, values["t_s"], values[name], name, colour)
            mark(panel, result, name)
        row[1].set(ylabel="")
        row[1].set_title("", loc="right")  # said beside it
        row[1].set_xlim(-NEAR_S * 1e3, NEAR_S * 1e3)
    for panel in panels[-1]:
        panel.set_xlabel("time from the focus (ms)")
    figure.align_ylabels(panels[:, 0])


def _sliding_courses(figure: SubFigure, result: Result, drawn: list[str]) -> None:
    """What a finger that slides meets, over a time of its own."""
    values = result.values
    panels = figure.subplots(len(drawn), 1, squeeze=False, sharex=True)[:, 0]
    for panel, name, colour in zip(panels, drawn, cycle(COLOURS[2:]), strict=False):
        draw_course(panel, values[SLIDING_TIME], values[name], name, colour)
        mark(panel, result, name)
    panels[-1].set_xlabel("time of sliding (ms)")
    figure.align_ylabels(panels)
