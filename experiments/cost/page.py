"""The page of all ladders: words, tables and figures from one run."""

import math
from collections.abc import Sequence
from datetime import date
from pathlib import Path

from tactometry.errors import attempt

from .figures import error_against_price, frontier, write_svg
from .measure import GOALS, Climb, Point, cheapest
from .peers import peers_of, recorded_on
from .report import label, machine

HEAD = """# What accuracy costs

<!-- not run: all ladders take an hour; tests/experiments/test_ladders.py climbs each -->
```console
$ tactometry cost all --out cost            # every ladder: table, cost/cost.csv, a figure each
$ tactometry cost skin-propagator
$ tactometry cost all --page docs/explanation/cost.md   # this page
```

Each section takes one problem with settings from coarse to fine and compares each setting with the stated reference.
The price is computing time (median of warm calls on one thread), emission time (`reversal-time-*`) or the time of
participants (`procedures`, `group-threshold`). `cost.csv` of the command also has first calls, memory and the size of
the result. Errors are the same in every run; times are those of the machine below. A result that is not finite is
marked *unstable*. Every reference agrees with an independent one, and no error below its uncertainty is reported.

Hollow points are other programs on the same problem, recorded by `benchmarks/ladder_peers.py`. Their times are scaled
by the finest setting of ours, which was measured with them.
"""
TAIL = """
## Adding a ladder

One file in `experiments/ladders/` that gives a `Problem`, one line in its table `LADDERS`. The laws then run on it: the
error falls along the ladder, the reference agrees with an independent one, errors are the same in every run.
"""


def write_page(climbs: Sequence[Climb], path: Path, today: date) -> None:
    """The page, and a figure of each ladder in a folder beside it, named as the page.

    Raises
    ------
    DeviceFailed
        If a file cannot be written.
    """
    folder = path.with_suffix("")
    with attempt(path, "cannot write", "a place to write to"):
        folder.mkdir(parents=True, exist_ok=True)
        for climb in climbs:
            write_svg(error_against_price(climb, peers_of(climb)), folder / f"{climb.problem.name}.svg")
        path.write_text(page(climbs, folder.name, today), encoding="utf-8")


def page(climbs: Sequence[Climb], folder: str, today: date) -> str:
    """The text of the page."""
    heads = " | ".join(f"{goal:.2%}" for goal in GOALS)
    lines = [HEAD, f"Measured on {today.isoformat()}: {machine()}. Peers: {recorded_on()}.", ""]
    lines += [
        "## The cheapest rung for an error",
        "",
        f"| ladder | {heads} | one more digit |",
        "|---|---|---|---|---|---|",
    ]
    for climb in climbs:
        prices = " | ".join(_price(climb, goal) for goal in GOALS)
        lines.append(f"| [`{climb.problem.name}`](#{climb.problem.name}) | {prices} | {digit(climb)} |")
    lines += [text for climb in climbs for text in _section(climb, folder)]
    return "\n".join(lines) + TAIL


def digit(climb: Climb) -> str:
    """What a tenth of the error costs: the factor of the price per digit, from end to end of the frontier."""
    best = frontier(climb)
    digits = math.log10(best[0][1] / best[-1][1])
    return f"x {(best[-1][0] / best[0][0]) ** (1 / digits):.2g}" if digits > 0 else "nothing"


def _price(climb: Climb, goal: float) -> str:
    point = cheapest(climb, goal)
    if point is None:
        return "not reached"
    unit = climb.problem.price.partition("(")[2].partition(")")[0]
    return f"{label(point)}: {point.price:.2g} {unit}".rstrip()


def _section(climb: Climb, folder: str) -> list[str]:
    problem = climb.problem
    title = f"{problem.title[0].upper()}{problem.title[1:]}"
    words = f"{title}. Reference: {problem.reference.by} (good to {climb.floor:.0e}); "
    rows = [_row(point) for point in (*climb.points, *peers_of(climb))]
    return [
        "",
        f"## {problem.name}",
        "",
        f"{words}checked against: {problem.independent.by}. Price: {problem.price}.",
        "",
        f"![error against price]({folder}/{problem.name}.svg)",
        "",
        "| setting | error | price |",
        "|---|---|---|",
        *rows,
    ]


def _row(point: Point) -> str:
    error = "unstable" if point.unstable else f"{point.error:.1e}"
    return f"| {label(point)} | {error} | {point.price:.3g} |"
