"""Figures of a group: thresholds, and rates against level."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from ..anova.group_means import HIGH, LOW
from ..tasks.kinds import CURVES
from .axes import FactorAxis, means_with_intervals, panels, place, series, shift
from .style import Drawing, drawn, house_style, look, new_figure, shades

BESIDE = 0.4
"""Of the step from one series to the next: where the dots of participants lie, so that no bar hides them."""
ROOM = 1.05
"""Above the highest value of an axis that begins at 0."""
MOST_INSIDE = 4
"""More series than these have their legend beside the figure."""
OPEN = {"mfc": "none", "alpha": 0.8}

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
    from_zero: bool = False,
) -> Drawing:
    """Mean over participants with its 95 % interval against the main factor, a line per series: within participants
    where `group` has such (`within_low`, `within_high`), with the one between them as a thin line behind it. Single
    participants are faint dots, and open triangles where `individuals` have a bound (`LOW`, `HIGH`), `targets` dashed
    lines. `from_zero` lets the axis of values begin at 0."""
    axis = FactorAxis.of(group, factors)
    with house_style():
        figure = new_figure(6.6, 3.6)
        axes = figure.add_subplot()
        where = place(axes, group[axis.along] if axis.along else ["all"], axis.along)
        parts, log = series(group, axis.series), axes.get_xscale() == "log"
        for n, (name, part) in enumerate(parts):
            _draw_means(axes, part, axis, shift(n, len(parts), where, log=log), name, n)
        for n, (_, part) in enumerate(series(individuals, axis.series)):
            beside = shift(n + BESIDE, len(parts), where, log=log)
            _draw_individuals(axes, part, axis, beside, dependent, look(n)["color"])
        for target in targets:
            axes.axhline(target, color="#777777", linestyle="--", linewidth=0.8, zorder=0)
        axes.set_ylabel(label)
        if from_zero:
            low, high = axes.get_ylim()
            axes.set_ylim(min(0.0, low), ROOM * high)
        _legend(axes, len(parts) if axis.series else 0, beside=len(targets) > 0)
        return drawn(figure)


def _legend(axes: "Axes", n: int, *, beside: bool = False) -> None:
    """Of `n` series: in the figure while they are few, `beside` it else."""
    if n > MOST_INSIDE or (n and beside):
        axes.get_figure().legend(loc="outside right center")  # type: ignore[union-attr]
    elif n:
        axes.legend(loc="best")


def _draw_means(
    axes: "Axes", part: pd.DataFrame, axis: FactorAxis, where: dict[object, float], name: str, n_series: int
) -> None:
    style = look(n_series)
    x = np.array([where[v] for v in (part[axis.along] if axis.along else ["all"] * len(part))])
    means_with_intervals(axes, x, part, label=name, **style)


def _draw_individuals(
    axes: "Axes", part: pd.DataFrame, axis: FactorAxis, where: dict[object, float], dependent: str, colour: str
) -> None:
    """Values as dots, bounds as open triangles."""
    kinds: tuple[tuple[str, dict[str, Any]], ...] = (
        (dependent, {"marker": ".", "alpha": 0.6}),
        (LOW, {"marker": "^"} | OPEN),
        (HIGH, {"marker": "v"} | OPEN),
    )
    for column, style in kinds:
        if column in part.columns:
            held = part[part[column].notna()]
            x = [where[v] for v in (held[axis.along] if axis.along else ["all"] * len(held))]
            axes.plot(x, held[column].astype(float), linestyle="", color=colour, markersize=4, zorder=1, **style)


def rate_figure(rates: pd.DataFrame, factors: Sequence[str], *, unit: str) -> Drawing:
    """Detection rate against level, one panel per series (force), one line per value of the main factor
    (frequency)."""
    axis = FactorAxis.of(rates, factors)

    def draw(axes: "Axes", panel: pd.DataFrame) -> None:
        lines = series(panel, [axis.along] if axis.along else [])
        for (line, part), colour in zip(lines, shades(len(lines)), strict=True):
            axes.plot(part["level"], part["rate"], "-", color=colour, label=line, marker="o", markersize=3)
        axes.set_ylim(-0.03, 1.03)

    labels = f"Level ({unit})" if unit else "Level", CURVES[str(rates["task"].iloc[0])].rate_label
    return panels(rates, axis, draw, labels=labels, height_in=2.5, share_x=True)


def mean_rate_figure(rates: pd.DataFrame, factors: Sequence[str]) -> Drawing:
    """Mean detection rate (all levels) against the main factor, a line per series."""
    axis = FactorAxis.of(rates, factors)
    with house_style():
        figure = new_figure(6.6, 3.0)
        axes = figure.add_subplot()
        where = place(axes, rates[axis.along] if axis.along else ["all"], axis.along)
        for n, (name, part) in enumerate(series(rates, axis.series)):
            x = [where[v] for v in (part[axis.along] if axis.along else ["all"])]
            axes.plot(x, part["rate"], label=name, **look(n))
        axes.set_ylabel(CURVES[str(rates["task"].iloc[0])].rate_label + ", all levels")
        axes.set_ylim(-0.03, 1.03)
        _legend(axes, len(series(rates, axis.series)) if axis.series else 0)
        return drawn(figure)
