"""Figure of one participant: rates and fitted curve per condition.

All panels are drawn in one matplotlib axes in inches, as an axes per panel would take ten times as long.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from tactometry.palette import COLOURS

from ..arrays import Array
from ..means import rate_interval
from ..tasks.cell import Estimate
from ..tasks.kinds import CURVES
from ..threshold.status import Status
from ..wording import condition_name, with_unit
from .style import Drawing, drawing_of, grid_of, look, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MAX_PANELS = 36
"""Largest number of conditions in a figure."""
RATES = (-0.12, 1.05)
"""Vertical range of a panel; the threshold with its interval is drawn below 0."""
BAR = -0.06
TICKS = (0.0, 0.5, 1.0)
MOST_TICKS = 3
POINT_IN = 1 / 72
TICK_IN = 2 * POINT_IN


@dataclass(frozen=True)
class Panel:
    """Panel of an estimate: position and size in inches, range of levels."""

    estimate: Estimate
    left: float
    bottom: float
    width: float
    height: float
    low: float
    high: float

    def x(self, levels: ArrayLike) -> Array:
        """Return the positions of levels, clipped to the axis."""
        margin = 0.04 * (self.high - self.low)
        start, stop = self.low - margin, self.high + margin
        return np.asarray(self.left + self.width * (np.clip(levels, start, stop) - start) / (stop - start))

    def y(self, rates: ArrayLike) -> Array:
        start, stop = RATES
        return np.asarray(self.bottom + self.height * (np.asarray(rates) - start) / (stop - start))

    @property
    def counts(self) -> tuple[Array, Array]:
        """Successes and trials at each level."""
        return np.array(self.estimate.cell.n_yes), np.array(self.estimate.cell.n_trials)

    @cached_property
    def ticks(self) -> list[float]:
        """Round levels at which the axis has ticks."""
        from matplotlib.ticker import MaxNLocator

        steps = MaxNLocator(MOST_TICKS, steps=[1, 2, 2.5, 5, 10]).tick_values(self.low, self.high)
        return [tick for tick in map(float, steps) if self.low <= tick <= self.high]

    @property
    def interval(self) -> tuple[float, float] | None:
        """Interval of the threshold; an unknown end is the end of the axis."""
        low, high = self.estimate.fit.interval_low, self.estimate.fit.interval_high
        if low is None and high is None:
            return None
        return (self.low if low is None else low), (self.high if high is None else high)


def curve_figure(estimates: Sequence[Estimate], factors: Sequence[str], *, unit: str) -> Drawing:
    """Draw a participant's rates, fitted curves and thresholds."""
    shown = list(estimates)[:MAX_PANELS]
    columns = min(7, len(shown)) if len(shown) > 8 else min(4, len(shown))
    rows = -(-len(shown) // columns)  # rounded up
    width_in, height_in = max(1.45 * columns, 3.0), 1.35 * rows + 0.5
    with new_figure(width_in, height_in) as figure:
        figure.set_layout_engine("none")
        axes = figure.add_axes((0, 0, 1, 1))
        axes.set(xlim=(0, width_in), ylim=(0, height_in))
        axes.set_axis_off()
        panels = list(_panels(shown, rows, columns, width_in, height_in))
        _draw_frames(axes, panels)
        _draw_rates(axes, [panel for panel in panels if panel.estimate.cell.levels])
        _draw_fits(axes, panels)
        for place, panel in enumerate(panels):
            _write(axes, panel, factors, is_left=place % columns == 0, is_last=place >= len(shown) - columns)
        figure.supxlabel(with_unit("Level", unit), fontsize=8)
        figure.supylabel(CURVES[shown[0].cell.task].rate_label, fontsize=8, x=0.08 / width_in)
        return drawing_of(figure)


def _panels(shown: Sequence[Estimate], rows: int, columns: int, width_in: float, height_in: float) -> Iterator[Panel]:
    levels = [x for estimate in shown for x in estimate.cell.levels] or [0.0, 1.0]
    low, high = min(levels), max(levels)
    span = (low, high) if low < high else (low - 1, high + 1)  # a single level has no range
    left, bottom = 0.62, 0.45
    across, up = (0.99 * width_in - left) / columns, (0.98 * height_in - bottom) / rows
    for place, estimate in enumerate(shown):
        column, row = place % columns, rows - 1 - place // columns
        yield Panel(estimate, left + column * across, bottom + row * up, 0.9 * across, 0.76 * up, *span)


def _lines(axes: "Axes", lines: Sequence[Any], **style: Any) -> None:
    from matplotlib.collections import LineCollection

    axes.add_collection(LineCollection(lines, **style), autolim=False)


def _draw_frames(axes: "Axes", panels: Sequence[Panel]) -> None:
    frames, ticks = [], []
    for panel in panels:
        left, bottom = panel.left, panel.bottom
        frames.append([(left, bottom + panel.height), (left, bottom), (left + panel.width, bottom)])
        ticks += [[(left - TICK_IN, y), (left, y)] for y in panel.y(TICKS)]
        ticks += [[(x, bottom - TICK_IN), (x, bottom)] for x in panel.x(panel.ticks)]
    _lines(axes, frames, colors="black", linewidths=0.8, joinstyle="miter", capstyle="projecting")
    _lines(axes, ticks, colors="black", linewidths=0.8)


def _draw_rates(axes: "Axes", panels: Sequence[Panel]) -> None:
    bars, dots, areas = [], [], []
    for panel in panels:
        x, (k, n) = panel.x(panel.estimate.cell.levels), panel.counts
        low, high = (panel.y(ends) for ends in rate_interval(k, n))
        bars += [[(at, start), (at, stop)] for at, start, stop in zip(x, low, high, strict=True)]
        dots.append(np.stack([x, panel.y(k / n)]))
        areas.append(3 + 14 * n / n.max())
    _lines(axes, bars, colors="#888888", linewidths=0.8, zorder=1)
    if dots:
        x, y = np.hstack(dots)
        axes.scatter(x, y, s=np.hstack(areas), color=look(0)["color"], linewidths=0, zorder=3)


def _draw_fits(axes: "Axes", panels: Sequence[Panel]) -> None:
    colour, curves, bars, marks = look(1)["color"], [], [], []
    for panel in panels:
        fit, bar = panel.estimate.fit, float(panel.y(BAR))
        if fit.function is not None:
            x = np.linspace(panel.low, panel.high, 80)
            curves.append(np.column_stack([panel.x(x), panel.y(fit.function.probability(x))]))
        if panel.interval is not None:
            bars.append([(x, bar) for x in panel.x(panel.interval)])
        if fit.threshold is not None:
            marks.append((float(panel.x(fit.threshold)), bar))
    _lines(axes, curves, colors=colour, linewidths=1.1)
    _lines(axes, bars, colors=colour, linewidths=2, capstyle="butt")
    if marks:
        axes.plot(*np.transpose(marks), "|", color="black", markersize=5)


def _write(axes: "Axes", panel: Panel, factors: Sequence[str], *, is_left: bool, is_last: bool) -> None:
    """Write the title, status and outer tick labels of a panel."""
    left, bottom, top = panel.left, panel.bottom, panel.bottom + panel.height
    title = condition_name(factors, panel.estimate.cell.condition)
    axes.text(left + panel.width / 2, top + 2 * POINT_IN, title, fontsize=7, ha="center", va="baseline")
    if panel.estimate.fit.status != Status.OK:
        words = str(panel.estimate.fit.status).replace("threshold_", "").replace("_", " ")
        place = left + 0.04 * panel.width, bottom + 0.93 * panel.height
        axes.text(*place, words, fontsize=6, va="top", color=look(1)["color"])
    away = TICK_IN + 3.5 * POINT_IN
    for rate, y in zip(TICKS, panel.y(TICKS), strict=True) if is_left else ():
        axes.text(left - away, y, f"{rate}", fontsize=6.5, ha="right", va="center_baseline")
    for level, x in zip(panel.ticks, panel.x(panel.ticks), strict=True) if is_last else ():
        axes.text(x, bottom - away, f"{level:g}".replace("-", "\u2212"), fontsize=6.5, ha="center", va="top")


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
