"""Figures of error over price."""

from collections.abc import Iterable, Sequence
from pathlib import Path

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.text import Annotation
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from matplotlib.transforms import BboxBase

from tactometry.palette import COLOURS

from .measure import GOALS, AccuracyCurve, Point

GREY = "#666666"
MARKERS = ("o", "s", "^", "D", "v", "P")
TOP = 2.0
"""Error at which unstable results are drawn."""
LABEL = {False: (4, 4), True: (5, -7)}
"""Offset of setting labels from their points (in typographic points), by whether the point was recorded."""
ELSEWHERE = ((4, 4, "left"), (5, -7, "left"), (-4, 4, "right"), (-5, -7, "right"), (0, 9, "center"), (0, -13, "center"))
"""Other offsets, with alignment, for labels that would overlap."""


def error_against_price(curve: AccuracyCurve, peers: Sequence[Point] = ()) -> Figure:
    """Plot error over price with the frontier, on log axes."""
    figure = Figure(figsize=(6.4, 4.5), layout="constrained", facecolor="white")
    axes = figure.subplots()
    points = (*curve.points, *peers)
    for place, name in enumerate(dict.fromkeys(point.contender for point in points)):
        own = [point for point in points if point.contender == name]
        _draw(axes, own, curve.floor, COLOURS[place % 6], MARKERS[place % 6], recorded=name not in curve.contenders)
    axes.loglog(*zip(*curve.frontier, strict=True), color=GREY, linewidth=1, zorder=1, label="cheapest")
    lowest = min([GOALS[-1], *(drawn_at(point, curve.floor) for point in points)]) / 5
    if curve.floor > 0:
        axes.axhspan(lowest / 10, curve.floor, color=GREY, alpha=0.2, label="reference's own error")
    axes.set(xlabel=curve.problem.price, ylabel="relative error", ylim=(lowest, 3 * TOP))
    _finish(axes, f"{curve.problem.name}\n{curve.problem.title}")
    figure.legend(fontsize="x-small", loc="outside lower center", ncols=3, frameon=False)
    _separate(figure, [text for text in axes.texts if isinstance(text, Annotation) and text.anncoords != "data"])
    return figure


def drawn_at(point: Point, floor: float) -> float:
    """Return a point's error, limited to the range of the axis."""
    return TOP if point.unstable else min(max(point.error, floor), TOP)


def _draw(axes: Axes, points: Iterable[Point], floor: float, colour: str, marker: str, *, recorded: bool) -> None:
    named = set()
    for n, point in enumerate(points):
        place = (point.price, drawn_at(point, floor))
        axes.loglog(
            *([value] for value in place),
            linestyle="",
            marker="x" if point.unstable else marker,
            color=colour,
            markerfacecolor="white" if recorded else colour,
            label="_" if n else f"{point.contender}{' (recorded)' if recorded else ''}",
        )
        text = f"{point.setting}{' (unstable)' if point.unstable else ''}"
        if (text, point.price) not in named:
            axes.annotate(text, place, LABEL[recorded], textcoords="offset points", fontsize="xx-small", color=colour)
        named.add((text, point.price))


def _separate(figure: Figure, labels: Sequence[Annotation]) -> None:
    """Move overlapping labels, and hide those without free space."""
    figure.draw_without_rendering()
    placed: list[BboxBase] = []
    for label in labels:
        for x_pt, y_pt, alignment in ((*label.xyann, "left"), *ELSEWHERE):
            label.set(position=(x_pt, y_pt), horizontalalignment=alignment)
            box = label.get_window_extent()
            if not box.count_overlaps(placed):
                placed.append(box)
                break
        else:
            label.set_visible(False)


def _finish(axes: Axes, title: str) -> None:
    for goal in GOALS:
        axes.axhline(goal, color=GREY, linewidth=0.6, linestyle=":")
        axes.text(1, goal, f" {goal:.2%}", transform=axes.get_yaxis_transform(), va="center", fontsize="x-small")
    axes.margins(x=0.15)
    low, high = axes.get_xlim()
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high < 300 * low else (1.0,), numticks=12))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda price, _: f"{price:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.tick_params(axis="x", labelsize="x-small")
    axes.set_title(title, fontsize="small", wrap=True)
    axes.grid(alpha=0.3)
    axes.spines[["top", "right"]].set_visible(False)


def write_svg(figure: Figure, path: Path) -> None:
    """Write a figure as SVG with the same bytes each time."""
    with mpl.rc_context({"svg.fonttype": "none", "svg.hashsalt": "tactometry"}):
        figure.savefig(path, metadata={"Date": None})
