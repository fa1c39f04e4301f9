"""The figures of a threshold study, each as an SVG element. matplotlib is used here and in `style` only."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from statsmodels.stats.proportion import proportion_confint

from tactometry.analysis.cells import Estimate
from tactometry.analysis.status import Status
from tactometry.analysis.style import house_style, look, new_figure, shades, svg

if TYPE_CHECKING:
    from matplotlib.axes import Axes

RATE_LABEL = {"yes_no": "Rate of “yes”", "forced_choice": "Rate correct", "comparison": "Rate of “more”"}
LOG_RANGE = 4.0
MAX_PANELS = 36
"""A participant's figure shows no more conditions than this."""


@dataclass(frozen=True)
class Axis:
    """Which factor runs along x, which ones make the series; both may be missing."""

    along: str | None
    series: tuple[str, ...]

    @classmethod
    def of(cls, table: pd.DataFrame, factors: Sequence[str]) -> "Axis":
        """The numeric factor with most levels along x, the others as series."""
        numeric = [name for name in factors if pd.api.types.is_numeric_dtype(table[name])]
        along = max(numeric or list(factors), key=lambda name: table[name].nunique(), default=None)
        return cls(along, tuple(name for name in factors if name != along))


UNITS = {"hz": "Hz", "n": "N", "s": "s", "v": "V", "m": "m", "mm": "mm", "db": "dB", "m_per_s": "m/s"}


def title_of(name: str) -> str:
    """A factor's name as a person writes it.

    >>> title_of("frequency_hz"), title_of("force_n"), title_of("pattern")
    ('Frequency (Hz)', 'Force (N)', 'Pattern')
    """
    for suffix in sorted(UNITS, key=len, reverse=True):
        if name.endswith(f"_{suffix}"):
            return f"{name[: -len(suffix) - 1].replace('_', ' ').capitalize()} ({UNITS[suffix]})"
    return name.replace("_", " ").capitalize()


def value_of(name: str, value: object) -> str:
    """A factor's value with its unit, such as ``240 Hz``.

    >>> value_of("frequency_hz", 240.0), value_of("pattern", "P0")
    ('240 Hz', 'P0')
    """
    text = f"{value:g}" if isinstance(value, int | float | np.number) else str(value)
    for suffix in sorted(UNITS, key=len, reverse=True):
        if name.endswith(f"_{suffix}"):
            return f"{text} {UNITS[suffix]}"
    return text if not isinstance(value, int | float | np.number) else f"{name.replace('_', ' ')} {text}"


def condition_name(factors: Sequence[str], condition: Sequence[object]) -> str:
    return ", ".join(value_of(name, value) for name, value in zip(factors, condition, strict=True)) or "all"


def _series(table: pd.DataFrame, names: Sequence[str]) -> list[tuple[str, pd.DataFrame]]:
    if not names:
        return [("", table)]
    grouped = table.groupby(list(names), sort=True, observed=True)
    return [(condition_name(names, key), part) for key, part in grouped]


def _place(axes: "Axes", values: Any, name: str | None) -> dict[object, float]:
    """Put the factor's values on the x axis (logarithmic where they span much) and say where each lies."""
    levels = sorted(set(values))
    axes.set_xlabel("" if name is None else title_of(name))
    numeric = all(isinstance(v, int | float | np.number) for v in levels)
    if not numeric or name is None:
        axes.set_xticks(range(len(levels)), [str(v) for v in levels])
        return {v: float(i) for i, v in enumerate(levels)}
    if levels[0] > 0 and levels[-1] / levels[0] > LOG_RANGE:
        axes.set_xscale("log")
        axes.xaxis.set_minor_locator(_no_ticks())
    axes.set_xticks([float(v) for v in levels], [f"{v:g}" for v in levels])
    return {v: float(v) for v in levels}


def _no_ticks() -> Any:
    from matplotlib.ticker import NullLocator

    return NullLocator()


def threshold_figure(
    group: pd.DataFrame, factors: Sequence[str], *, label: str, individuals: pd.DataFrame, dependent: str
) -> str:
    """Mean over participants with its 95 % interval against the main factor, a line per series; bounds as
    arrows, single participants as faint dots."""
    axis = Axis.of(group, factors)
    with house_style():
        figure = new_figure(6.6, 3.6)
        axes = figure.add_subplot()
        where = _place(axes, group[axis.along] if axis.along else ["all"], axis.along)
        parts = _series(group, axis.series)
        for place, (name, part) in enumerate(parts):
            shift = _shift(place, len(parts), where, log=axes.get_xscale() == "log")
            _draw_means(axes, part, axis, shift, name, place)
        _draw_individuals(axes, individuals, axis, where, dependent)
        axes.set_ylabel(label)
        if axis.series:
            axes.legend(loc="best", title=None)
        return svg(figure)


def _shift(place: int, n: int, where: dict[object, float], *, log: bool) -> dict[object, float]:
    """Series side by side, so that their intervals do not hide each other."""
    offset = place - (n - 1) / 2
    if log:
        return {value: x * 1.025**offset for value, x in where.items()}
    spots = sorted(where.values())
    step = min(np.diff(spots), default=1.0)
    return {value: x + 0.05 * step * offset for value, x in where.items()}


def _draw_means(
    axes: "Axes", part: pd.DataFrame, axis: Axis, where: dict[object, float], name: str, place: int
) -> None:
    style = look(place)
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
    for place, (_, part) in enumerate(_series(individuals, axis.series)):
        told = part[part[dependent].notna()]
        x = [where[v] for v in (told[axis.along] if axis.along else ["all"] * len(told))]
        axes.plot(x, told[dependent].astype(float), ".", color=look(place)["color"], alpha=0.28, markersize=3, zorder=1)


def rate_figure(rates: pd.DataFrame, factors: Sequence[str], *, unit: str) -> str:
    """Detection rate against level, one panel per series (force), one line per value of the main factor
    (frequency)."""
    axis = Axis.of(rates, factors)
    panels = _series(rates, axis.series)
    columns = min(3, len(panels))
    rows = -(-len(panels) // columns)
    with house_style():
        figure = new_figure(2.6 * columns + 1.4, 2.5 * rows + 0.4)
        grid = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True).ravel()
        for axes, (name, panel) in zip(grid, panels, strict=False):
            lines = _series(panel, [axis.along] if axis.along else [])
            for (line, part), colour in zip(lines, shades(len(lines)), strict=True):
                axes.plot(part["level"], part["rate"], "-", color=colour, label=line, marker="o", markersize=3)
            axes.set_title(name)
            axes.set_xlabel(f"Level ({unit})" if unit else "Level")
            axes.set_ylim(-0.03, 1.03)
        for axes in grid[len(panels) :]:
            axes.set_visible(False)
        for axes in grid[::columns]:
            axes.set_ylabel(RATE_LABEL[str(rates["task"].iloc[0])])
        handles, labels = grid[0].get_legend_handles_labels()
        if axis.along:
            figure.legend(handles, labels, loc="outside right center")
        return svg(figure)


def mean_rate_figure(rates: pd.DataFrame, factors: Sequence[str]) -> str:
    """Mean detection rate (all levels) against the main factor, a line per series."""
    axis = Axis.of(rates, factors)
    with house_style():
        figure = new_figure(6.6, 3.0)
        axes = figure.add_subplot()
        where = _place(axes, rates[axis.along] if axis.along else ["all"], axis.along)
        for place, (name, part) in enumerate(_series(rates, axis.series)):
            x = [where[v] for v in (part[axis.along] if axis.along else ["all"])]
            axes.plot(x, part["rate"], label=name, **look(place))
        axes.set_ylabel(RATE_LABEL[str(rates["task"].iloc[0])] + ", all levels")
        axes.set_ylim(-0.03, 1.03)
        if axis.series:
            axes.legend(loc="best")
        return svg(figure)


def curve_figure(found: Sequence[Estimate], factors: Sequence[str], *, unit: str) -> str:
    """One participant: in each condition the rate at each level with Wilson's 95 % interval, the fitted
    curve, and the threshold with its interval as a bar at the bottom."""
    shown = list(found)[:MAX_PANELS]
    columns = min(7, len(shown)) if len(shown) > 8 else min(4, len(shown))
    rows = -(-len(shown) // columns)
    levels = [x for estimate in shown for x in estimate.cell.levels] or [0.0, 1.0]
    span = (min(levels), max(levels)) if min(levels) < max(levels) else (min(levels) - 1, max(levels) + 1)
    with house_style():
        figure = new_figure(max(1.45 * columns, 3.0), 1.35 * rows + 0.5)
        for place, estimate in enumerate(shown):
            axes = _panel(figure, place, rows, columns)
            _draw_curve(axes, estimate, span)
            axes.set_title(condition_name(factors, estimate.cell.condition), fontsize=7, pad=2)
            axes.tick_params(
                labelsize=6.5, length=2, labelleft=place % columns == 0, labelbottom=place >= len(shown) - columns
            )
        task = shown[0].cell.task
        figure.supxlabel(f"Level ({unit})" if unit else "Level", fontsize=8)
        figure.supylabel(RATE_LABEL[task], fontsize=8, x=0.08 / figure.get_size_inches()[0])
        return svg(figure)


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


def track_figure(rows: pd.DataFrame, factors: Sequence[str], *, unit: str) -> str:
    """Staircases of one participant: level against trial, a panel per series (force), a line per value of the
    main factor (frequency); filled where the answer was yes or correct, open where not, catch trials left
    out."""
    axis = Axis.of(rows, factors)
    panels = _series(rows, axis.series)
    columns = min(3, len(panels))
    lines = -(-len(panels) // columns)
    with house_style():
        figure = new_figure(2.6 * columns + 1.4, 2.1 * lines + 0.4)
        grid = figure.subplots(lines, columns, squeeze=False, sharey=True).ravel()
        for axes, (name, panel) in zip(grid, panels, strict=False):
            _draw_tracks(axes, panel, axis)
            axes.set_title(name)
            axes.set_xlabel("Trial of the track")
        for axes in grid[len(panels) :]:
            axes.set_visible(False)
        for axes in grid[::columns]:
            axes.set_ylabel(f"Level ({unit})" if unit else "Level")
        handles, labels = grid[0].get_legend_handles_labels()
        if axis.along:
            figure.legend(handles, labels, loc="outside right center")
        return svg(figure)


def _draw_tracks(axes: "Axes", panel: pd.DataFrame, axis: Axis) -> None:
    tracks = [name for name in (axis.along, "track", "session") if name and name in panel.columns]
    parts = _series(panel, [axis.along] if axis.along else [])
    for (name, part), colour in zip(parts, shades(len(parts)), strict=True):
        for place, (_, track) in enumerate(part.groupby(tracks) if tracks else [("", part)]):
            x = np.arange(1, len(track) + 1)
            up = track["yes"].to_numpy() == 1
            level = track["level"].to_numpy()
            axes.plot(x, level, "-", color=colour, linewidth=0.9, label=name if place == 0 else None)
            axes.plot(x[up], level[up], "o", color=colour, markersize=2.2)
            axes.plot(x[~up], level[~up], "o", color=colour, markersize=2.6, mfc="white", mew=0.7)
