"""`tactometry cost`."""

from dataclasses import asdict
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

import click

from tactometry.experiments.cost.measure import Climb, climb
from tactometry.experiments.cost.report import answers, machine, table, write_csv
from tactometry.experiments.ladders import LADDERS, problem_of
from tactometry.experiments.ladders.cold import cold_s

from ..arguments.require import one_of
from .output import path_option, progress, say, subcommand


@subcommand("cost skin-propagator --out cost")
@click.argument("ladder", metavar="LADDER|all")
@path_option("--out", help="Write a CSV of all points and a figure per ladder.")
@path_option("--page", help="Write a page (Markdown) with tables and figures.")
@click.option("--rounds", default=5, show_default=True, type=click.IntRange(1), help="Warm calls of each rung.")
def command(*, ladder: str, out: Path | None, page: Path | None, rounds: int) -> None:
    """What accuracy costs: error, time and memory of each setting, and the cheapest one for an error.

    Errors are the same in every run; times are those of this machine, now.
    """
    one_of("LADDER", ladder, ("all", *LADDERS))
    names = list(LADDERS) if ladder == "all" else [ladder]
    climbs = [climb(problem_of(name), rounds, partial(cold_s, name)) for name in progress(names, len(names), "ladders")]
    if out is not None:
        _write(climbs, out)
    if page is not None:
        from tactometry.experiments.cost.page import write_page

        write_page(climbs, page, datetime.now(UTC).date())
    say("\n\n".join([*map(table, climbs), machine()]), _record(climbs))


def _write(climbs: list[Climb], out: Path) -> None:
    from tactometry.experiments.cost.figures import error_against_price
    from tactometry.experiments.cost.peers import peers_of

    write_csv(climbs, out / "cost.csv")
    for rungs in climbs:
        figure = error_against_price(rungs, peers_of(rungs))
        figure.savefig(out / f"{rungs.problem.name}.png", dpi=150)


def _record(climbs: list[Climb]) -> dict[str, object]:
    ladders = {
        climb.problem.name: {
            "points": [asdict(point) | ({"error": None} if point.unstable else {}) for point in climb.points],
            "reference_error": climb.floor,
            "cheapest": answers(climb),
        }
        for climb in climbs
    }
    return {"machine": machine(), "ladders": ladders}
