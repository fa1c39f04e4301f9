"""Other programs on the ladders of `tactometry cost`, recorded for its figures.

    OMP_NUM_THREADS=1 python benchmarks/ladder_peers.py [LADDER ...]

Finite differences, scikit-fem, other polynomials, Newmark's method and `solve_ivp`, psignifit and questplus run
interleaved with our own rungs, on one thread. The rows of the ladders that ran are written anew to
`experiments/cost/peers.csv`, with the time of our finest rung in the same run as yardstick.
"""

import csv
import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict, fields, replace
from datetime import UTC, datetime
from functools import partial

import ladder_peers_fits
import ladder_peers_motion
import ladder_peers_plates

from tactometry.experiments.cost.measure import Point, climb
from tactometry.experiments.cost.peers import RECORD
from tactometry.experiments.cost.problem import OURS, Rung
from tactometry.experiments.cost.report import machine, table
from tactometry.experiments.ladders import LADDERS, problem_of

PEERS: dict[str, Callable[[], Sequence[Rung]]] = {
    "plate-modes-simply-supported": ladder_peers_plates.simply_supported,
    "plate-modes-free": ladder_peers_plates.free,
    "boundary-basis": ladder_peers_plates.other_bases,
    "time-integration": ladder_peers_motion.modes,
    "skin-propagator": ladder_peers_motion.skin,
    "friction-events": ladder_peers_motion.break_away,
    "threshold-fit": ladder_peers_fits.threshold,
    "quest-plus-grid": ladder_peers_fits.quest_plus,
}
COLUMNS = [*(field.name for field in fields(Point)), "yardstick_s", "recorded"]


def measured(ladder: str, n_rounds: int = 3) -> list[dict[str, object]]:
    problem = problem_of(ladder)
    found = climb(replace(problem, rungs=(*PEERS[ladder](), *problem.rungs)), n_rounds)
    print(table(found), end="\n\n", flush=True)
    extra = {"yardstick_s": found.points[-1].median_s, "recorded": f"{datetime.now(UTC).date()}, {machine()}"}
    return [asdict(point) | extra for point in found.points if point.contender != OURS]


def kept(without: Sequence[str]) -> list[dict[str, object]]:
    with RECORD.open(newline="", encoding="utf-8") as file:
        return [dict(row) for row in csv.DictReader(file) if row["ladder"] not in without]


def main(names: Sequence[str]) -> None:
    for name in names:
        rows = [*kept([name]), *measured(name)]
        with RECORD.open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
            writer.writeheader()
            writer.writerows(sorted(rows, key=partial(_place, list(LADDERS))))


def _place(order: list[str], row: dict[str, object]) -> int:
    return order.index(str(row["ladder"]))


if __name__ == "__main__":
    main(sys.argv[1:] or list(PEERS))
