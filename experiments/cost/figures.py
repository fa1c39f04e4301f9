"""Error against price, log-log: points, the frontier, the floor of the reference, unstable points at the top."""

from collections.abc import Iterable, Sequence
from pathlib import Path

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.text import Annotation
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from matplotlib.transforms import BboxBase

from tactometry.palette import COLOURS

from .measure import GOALS, Climb, Point

GREY = "#666666"
MARKERS = ("o", "s", "^", "D", "v", "P")
TOP = 2.0
LABEL = {False: (4, 4), True: (5, -7)}
"""Where a setting is written beside its point, in points: above ours, below what is recorded."""
ELSEWHERE = ((4, 4, "left"), (5, -7, "left"), (-4, 4, "right"), (-5, -7, "right"), (0, 9, "center"), (0, -13, "center"))
"""Where it is written if it would cover another, with its alignment."""


def error_against_price(climb: Climb, peers: Sequence[Point] = ()) -> Figure:
    """One ladder; a point below the reference's own error is drawn at it. Hollow points are recorded peers."""
    figure = Figure(figsize=(6.4, 4.5), layout="constrained", facecolor="white")
    axes = figure.subplots()
    names = dict.fromkeys([*climb.contenders, *(point.contender for point in peers)])
    for place, name in enumerate(names):
        points = [point for point in (*climb.points, *peers) if point.contender == name]
        _draw(axes, points, climb.floor, COLOURS[place % 6], MARKERS[place % 6], recorded=name not in climb.contenders)
    axes.loglog(*zip(*frontier(climb), strict=True), color=GREY, linewidth=1, zorder=1, label="cheapest")
    errors = [drawn_at(point, climb.floor) for point in (*climb.points, *peers)]
    lowest = min([GOALS[-1], *errors]) / 5
    if climb.floor > 0:
        axes.axhspan(lowest / 10, climb.floor, color=GREY, alpha=0.2, label="reference's own error")
    axes.set(xlabel=climb.problem.price, ylabel="relative error", ylim=(lowest, 3 * TOP))
    _finish(axes, f"{climb.problem.name}\n{climb.problem.title}")
    figure.legend(fontsize="x-small", loc="outside lower center", ncols=3, frameon=False)
    _part(figure, [text for text in axes.texts if isinstance(text, Annotation) and text.anncoords == "offset points"])
    return figure


def drawn_at(point: Point, floor: float) -> float:
    """The error, within the floor and the top of the figure."""
    return TOP if point.unstable else min(max(point.error, floor), TOP)


def _draw(axes: Axes, points: Iterable[Point], floor: float, colour: str, marker: str, *, recorded: bool) -> None:
    for n, point in enumerate(points):
        axes.loglog(
            [point.price],
            [drawn_at(point, floor)],
            linestyle="",
            marker="x" if point.unstable else marker,
            color=colour,
            markerfacecolor="white" if recorded else colour,
            label="_" if n else f"{point.contender}{' (recorded)' if recorded else ''}",
        )
        place = (point.price, drawn_at(point, floor))
        text = f"{point.setting}{' (unstable)' if point.unstable else ''}"
        said = {(label.get_text(), label.xy[0]) for label in axes.texts if isinstance(label, Annotation)}
        if (text, point.price) not in said:
            axes.annotate(text, place, LABEL[recorded], textcoords="offset points", fontsize="xx-small", color=colour)


def _part(figure: Figure, labels: Sequence[Annotation]) -> None:
    """Move labels off each other, and leave out those for which there is no place."""
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
    """Lines at the errors that are asked for, ticks at 1, 2 and 5, a legend out of the way."""
    for goal in GOALS:
        axes.axhline(goal, color=GREY, linewidth=0.6, linestyle=":")
        axes.annotate(f" {goal:.2%}", (1, goal), xycoords=("axes fraction", "data"), va="center", fontsize="x-small")
    axes.margins(x=0.15)
    low, high = axes.get_xlim()
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high < 300 * low else (1.0,), numticks=12))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda price, _: f"{price:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.tick_params(axis="x", labelsize="x-small")
    axes.set_title(title, fontsize="small", wrap=True)
    axes.grid(alpha=0.3)
    axes.spines[["top", "right"]].set_visible(False)


def frontier(climb: Climb) -> list[tuple[float, float]]:
    """Prices and errors of the points that no other point beats in both."""
    best: list[tuple[float, float]] = []
    for point in sorted(climb.points, key=lambda each: (each.price, each.error)):
        if not point.unstable and (not best or max(point.error, climb.floor) < best[-1][1]):
            best.append((point.price, max(point.error, climb.floor)))
    return best


def write_svg(figure: Figure, path: Path) -> None:
    """The same bytes for the same figure, with letters as text."""
    with mpl.rc_context({"svg.fonttype": "none", "svg.hashsalt": "tactometry"}):
        figure.savefig(path, metadata={"Date": None})
