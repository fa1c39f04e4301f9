"""Error against price, log-log: points, the frontier, the floor of the reference, unstable points at the top."""

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from tactometry.experiments.ladders.measure import GOALS, Climb

BLUE, ORANGE, GREY = "#0072B2", "#D55E00", "#666666"
TOP = 2.0


def error_against_price(found: Climb) -> Figure:
    """One ladder; a point below the reference's own error is drawn at it."""
    figure = Figure(figsize=(6.4, 4.2), layout="constrained")
    axes = figure.subplots()
    stable = [(point, max(point.error, found.floor)) for point in found.points if not point.unstable]
    axes.loglog([point.price for point, _ in stable], [error for _, error in stable], "o", color=BLUE, label="rungs")
    axes.loglog(*zip(*frontier(found), strict=True), color=BLUE, linewidth=1, label="cheapest")
    for point, error in stable:
        axes.annotate(point.setting, (point.price, error), (4, 4), textcoords="offset points", fontsize="x-small")
    unstable = [point.price for point in found.points if point.unstable]
    if unstable:
        axes.loglog(unstable, [TOP] * len(unstable), "x", color=ORANGE, label="unstable")
    lowest = min([GOALS[-1], *(error for _, error in stable)]) / 5
    axes.axhspan(lowest / 10, found.floor, color=GREY, alpha=0.2, label="reference's own error")
    axes.set(xlabel=found.problem.price, ylabel="relative error", ylim=(lowest, 3 * TOP))
    _finish(axes, f"{found.problem.name}\n{found.problem.title}")
    return figure


def _finish(axes: Axes, title: str) -> None:
    """Lines at the errors that are asked for, ticks at 1, 2 and 5, a legend out of the way."""
    for goal in GOALS:
        axes.axhline(goal, color=GREY, linewidth=0.6, linestyle=":")
        axes.annotate(f" {goal:.2%}", (1, goal), xycoords=("axes fraction", "data"), va="center", fontsize="x-small")
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0), numticks=12))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda price, _: f"{price:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.tick_params(axis="x", labelsize="x-small")
    axes.margins(x=0.15)
    axes.set_title(title, fontsize="small", wrap=True)
    axes.grid(alpha=0.3)
    axes.legend(fontsize="x-small", loc="upper right")
    axes.spines[["top", "right"]].set_visible(False)


def frontier(found: Climb) -> list[tuple[float, float]]:
    """Prices and errors of the points that no other point beats in both."""
    best: list[tuple[float, float]] = []
    for point in sorted(found.points, key=lambda each: (each.price, each.error)):
        if not point.unstable and (not best or max(point.error, found.floor) < best[-1][1]):
            best.append((point.price, max(point.error, found.floor)))
    return best
