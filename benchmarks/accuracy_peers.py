"""Run other programs on the accuracy problems of `tactometry cost`, and record their points.

    OMP_NUM_THREADS=1 python benchmarks/accuracy_peers.py [PROBLEM ...]

The other programs take turns with our settings on one thread. The rows of these problems are replaced in
`experiments/accuracy/peers.csv`. Each row contains the time of our finest setting in the same run as a yardstick.
"""

import csv
import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict, fields, replace
from datetime import UTC, datetime

import peers_of_fits
import peers_of_motion
import peers_of_plates

from tactometry.experiments.accuracy import PROBLEMS, problem_of
from tactometry.experiments.accuracy.measure import OURS, PEERS as RECORD, Point, Setting, measure
from tactometry.experiments.accuracy.page import table
from tactometry.experiments.harness import machine

PEERS: dict[str, Callable[[], Sequence[Setting]]] = {
    "plate-modes-simply-supported": peers_of_plates.simply_supported,
    "plate-modes-free": peers_of_plates.free,
    "boundary-basis": peers_of_plates.other_bases,
    "time-integration": peers_of_motion.modes,
    "skin-propagator": peers_of_motion.skin,
    "friction-events": peers_of_motion.break_away,
    "threshold-fit": peers_of_fits.threshold,
    "quest-plus-grid": peers_of_fits.quest_plus,
}
COLUMNS = [*(field.name for field in fields(Point)), "yardstick_s", "recorded"]


def measured(name: str, n_rounds: int = 3) -> list[dict[str, object]]:
    problem = problem_of(name)
    curve = measure(replace(problem, settings=(*PEERS[name](), *problem.settings)), n_rounds)
    print(table(curve), end="\n\n", flush=True)
    extra = {"yardstick_s": curve.points[-1].median_s, "recorded": f"{datetime.now(UTC).date()}, {machine()}"}
    return [asdict(point) | extra for point in curve.points if point.contender != OURS]


def main(names: Sequence[str]) -> None:
    for name in names:
        with RECORD.open(newline="", encoding="utf-8") as file:
            rows = [row for row in csv.DictReader(file) if row["problem"] != name]
        rows = sorted([*rows, *measured(name)], key=lambda row: list(PROBLEMS).index(row["problem"]))
        with RECORD.open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)


if __name__ == "__main__":
    main(sys.argv[1:] or list(PEERS))
