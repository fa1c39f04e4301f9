"""Terminal table, CSV and documentation page of accuracy curves."""

import math
from collections.abc import Iterator, Sequence
from datetime import date
from pathlib import Path

from tactometry.errors import attempt

from ..harness import machine, table as markdown
from .measure import GOALS, OURS, AccuracyCurve, Point, Problem, peers_of, recorded_on

ROW = "{:<29}{:>9}{:>10}{:>10}{:>10}{:>8}{:>11}{:>11}"
HEAD = """# What accuracy costs

<!-- not run: all problems take an hour; tests/experiments/test_accuracy.py measures each -->
```console
$ tactometry cost all --out cost            # every problem: table, cost/cost.csv, a figure each
$ tactometry cost skin-propagator
$ tactometry cost all --page docs/explanation/cost.md   # this page
```

Each section compares settings of one problem, from coarse to fine, with a reference. The price is computing time (s,
median of warm calls on one thread) unless stated otherwise. `cost.csv` also contains first calls, memory and the size
of the result. Errors are the same in every run. Times are those of the machine below. A result that is not finite is
*unstable*. References use another method, or agree with one. No error below their uncertainty is reported.

Hollow points are other programs on the same problem, recorded by `benchmarks/accuracy_peers.py`. Their times are scaled
by our finest setting, which was measured with them.
"""
TAIL = """
## Adding a problem

Add a file to `experiments/accuracy/problems/` with a function that returns a `Problem`, and a line to `PROBLEMS`. Tests
then check that the error falls from setting to setting, that references agree, and that errors are repeatable.
"""


def table(curve: AccuracyCurve) -> str:
    """Return a table of the points (98 columns), and the cheapest settings."""
    problem = curve.problem
    lines = [f"{problem.name}: {problem.title}", f"against {problem.reference.by}", f"price: {problem.price}"]
    lines.append(ROW.format("setting", "error", "price", "cold (s)", "warm (s)", "+- (s)", "memory (B)", "answer (B)"))
    for point in curve.points:
        times = f"{point.first_s:.3g}", f"{point.median_s:.3g}", f"{point.spread_s:.1g}"
        numbers = _error(point), f"{point.price:.3g}", *times, point.peak_bytes, point.answer_bytes
        lines.append(ROW.format(label(point), *numbers))
    return "\n".join([*lines, f"reference good to {curve.floor:.0e}", *answers(curve)])


def answers(curve: AccuracyCurve) -> list[str]:
    """Return a line with the cheapest setting for each error goal."""
    lines = []
    for goal in GOALS:
        point = curve.cheapest(goal)
        reached = "no setting reaches it" if point is None else f"{label(point)}, price {point.price:.3g}"
        lines.append(f"{goal:.2%}: {reached}")
    return lines


def label(point: Point) -> str:
    """Return a point's setting, with the program unless it is Tactometry."""
    return point.setting if point.contender == OURS else f"{point.contender}, {point.setting}"


def _error(point: Point) -> str:
    return "unstable" if point.unstable else f"{point.error:.1e}"


def write_page(curves: Sequence[AccuracyCurve], path: Path, today: date) -> None:
    """Write the page, and its figures into a folder of the same name."""
    from .figures import error_against_price, write_svg

    folder = path.with_suffix("")
    with attempt(path, "cannot write", "a place to write to"):
        folder.mkdir(parents=True, exist_ok=True)
        for curve in curves:
            write_svg(error_against_price(curve, peers_of(curve)), folder / f"{curve.problem.name}.svg")
        path.write_text(page(curves, folder.name, today), encoding="utf-8")


def page(curves: Sequence[AccuracyCurve], folder: str, today: date) -> str:
    """Return the page as Markdown."""
    measured = f"Measured on {today.isoformat()}: {machine()}. Peers: {recorded_on()}."
    rows = []
    for curve in curves:
        points = (curve.cheapest(goal) for goal in GOALS)
        prices = ("" if point is None else f"{point.price:.2g}" for point in points)
        rows.append((f"[`{curve.problem.name}`](#{curve.problem.name})", *prices, digit(curve)))
    cheapest = markdown(("problem", *(f"{goal:.2%}" for goal in GOALS), "one more digit"), rows)
    lines = [HEAD, measured, "", "## Lowest price for an error", "", cheapest]
    return "\n".join([*lines, *(line for curve in curves for line in _section(curve, folder))]) + TAIL


def digit(curve: AccuracyCurve) -> str:
    """Return the factor by which the price rises per tenfold smaller error."""
    best = curve.frontier
    digits = math.log10(best[0][1] / best[-1][1])
    return f"x {(best[-1][0] / best[0][0]) ** (1 / digits):.2g}" if digits > 0 else "nothing"


def _section(curve: AccuracyCurve, folder: str) -> Iterator[str]:
    problem = curve.problem
    title = f"{problem.title[0].upper()}{problem.title[1:]}"
    yield f"\n## {problem.name}\n"
    checked = f", checked against {problem.independent.by}" if problem.independent else ""
    price = "" if problem.price == Problem.price else f" Price: {problem.price}."
    yield f"{title}. Reference: {problem.reference.by} (good to {curve.floor:.0e}){checked}.{price}\n"
    yield f"![error against price]({folder}/{problem.name}.svg)\n"
    points = (*curve.points, *peers_of(curve))
    yield markdown(("setting", "error", "price"), [(label(each), _error(each), f"{each.price:.3g}") for each in points])
