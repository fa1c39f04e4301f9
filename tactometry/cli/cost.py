"""`tactometry cost`."""

from dataclasses import asdict
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

import click

from tactometry.experiments.accuracy import PROBLEMS, problem_of
from tactometry.experiments.accuracy.measure import AccuracyCurve, Point, cold_s, measure, peers_of
from tactometry.experiments.accuracy.page import answers, table, write_page
from tactometry.experiments.harness import machine

from ..arguments.require import one_of
from ..files.rows import write_records
from .output import path_option, progress, say, subcommand


@subcommand("cost skin-propagator --out cost")
@click.argument("problem", metavar="PROBLEM|all")
@path_option("--out", help="Folder for a CSV of all points and a figure per problem.")
@path_option("--page", help="Write a page (Markdown) with tables and figures.")
@click.option("--rounds", default=5, type=click.IntRange(1), help="Number of timed calls per setting, after the first.")
def command(*, problem: str, out: Path | None, page: Path | None, rounds: int) -> None:
    """Measure error, time and memory, and find the cheapest settings.

    Errors are the same in every run. Times depend on the machine.
    """
    one_of("PROBLEM", problem, ("all", *PROBLEMS))
    names = list(PROBLEMS) if problem == "all" else [problem]
    curves = [measure(problem_of(name), rounds, partial(cold_s, name)) for name in progress(names, len(names), "cost")]
    if out is not None:
        _write(curves, out)
    if page is not None:
        write_page(curves, page, datetime.now(UTC).date())
    say("\n\n".join([*map(table, curves), machine()]), _record(curves))


def _write(curves: list[AccuracyCurve], out: Path) -> None:
    from tactometry.experiments.accuracy.figures import error_against_price

    write_records(Point, (point for curve in curves for point in curve.points), out / "cost.csv")
    for curve in curves:
        error_against_price(curve, peers_of(curve)).savefig(out / f"{curve.problem.name}.png", dpi=150)


def _record(curves: list[AccuracyCurve]) -> dict[str, object]:
    problems = {
        curve.problem.name: {
            "points": [asdict(point) | ({"error": None} if point.unstable else {}) for point in curve.points],
            "reference_error": curve.floor,
            "cheapest": answers(curve),
        }
        for curve in curves
    }
    return {"machine": machine(), "problems": problems}
