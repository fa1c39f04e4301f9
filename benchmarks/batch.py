"""Count sessions per second in batches, compared with PsychoPy and questplus.

The compared programs are loops with PsychoPy's StairHandler and with questplus. Tracks with mode fits are timed too.

    OMP_NUM_THREADS=1 python benchmarks/batch.py [--sets 2000] [--peers 20] [--batches 4]

Times are for one core, after imports and compilation. A `table` states the sensation level of each level, like a scene.
With --tracks 1000000 [--out DIR] [--jobs 2], this number of tracks is fitted and written to Parquet instead. An
interrupted run with --out continues.
"""

import argparse
import math
import os
import resource
import time
import warnings
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from pyarrow import parquet

from tactometry.experiments.bias_study.batches import BATCH, Respondents, TrackRun, fitted_tracks, write_tracks
from tactometry.experiments.harness import run_once, tell
from tactometry.experiments.workers import workers
from tactometry.protocols import QuestPlus, Staircase
from tactometry.protocols.batch.answers import LevelTable, criteria
from tactometry.protocols.batch.tracks import tracks
from tactometry.protocols.bayesian.parameter_grid import ParameterGrid
from tactometry.psychometric import shape_named

N_TRIALS, N_TRIALS_QUEST, ENDLESS = 140, 60, 10**6
PEOPLE = Respondents(20.0, 3.0, 8.0, guess_rate=0.5, lapse_rate=0.02)
CURVE = (PEOPLE.width, PEOPLE.guess_rate, PEOPLE.lapse_rate)
LEVELS = np.linspace(0.0, 40.0, 41)
TABLE = LevelTable(LEVELS, LEVELS - 0.002 * (LEVELS - 20.0) ** 2)
STAIRCASE = Staircase(36.0, (8.0, 4.0, 2.0), 0.0, 40.0, n_reversals=ENDLESS, n_trials=N_TRIALS, n_at_bound=ENDLESS)
SDS, LAPSES = (1.2, 1.8, 2.7, 4.0, 6.0), (0.0, 0.02, 0.05)


def quest_plus() -> QuestPlus:
    widths = tuple(shape_named("normal").z_width * sd for sd in SDS)
    grid = ParameterGrid(tuple(LEVELS.tolist()), widths, (0.5,), LAPSES, "normal")
    return QuestPlus(tuple(LEVELS.tolist()), grid, N_TRIALS_QUEST)


def ours(rule: Staircase | QuestPlus, n_trials: int, n_sets: int, table: LevelTable | None) -> None:
    rng = np.random.default_rng()
    thresholds = PEOPLE.threshold + PEOPLE.threshold_sd * rng.standard_normal((n_sets, 1))
    tracks(rule, criteria(rng.random((n_sets, n_trials)), PEOPLE.shape, thresholds, *CURVE), table)


def person(table: LevelTable | None, rng: np.random.Generator) -> Callable[[float], bool]:
    """Return a function that simulates one participant's answers by a Gumbel function."""
    threshold = PEOPLE.threshold + PEOPLE.threshold_sd * float(rng.standard_normal())
    curve, (width, guess, lapse) = shape_named(PEOPLE.shape), CURVE

    def answer(level: float) -> bool:
        felt = level if table is None else float(np.interp(level, table.levels, table.felt[0]))
        z = curve.z50 + (felt - threshold) / width * curve.z_width
        return bool(rng.random() < guess + (1 - guess - lapse) * -math.expm1(-math.exp(z)))

    return answer


def stair_handlers(n_sets: int, table: LevelTable | None) -> None:
    from psychopy.data import StairHandler

    rng = np.random.default_rng()
    options = {"nReversals": 1, "stepSizes": [8, 4, 2], "nTrials": N_TRIALS, "nUp": 1, "nDown": 2}
    for _ in range(n_sets):
        answer = person(table, rng)
        stairs = StairHandler(36.0, minVal=0, maxVal=40, stepType="lin", autoLog=False, **options)
        for level in stairs:
            stairs.addResponse(int(answer(level)))


def questplus_package(n_sets: int, table: LevelTable | None) -> None:
    import questplus

    rng = np.random.default_rng()
    axes = {"mean": LEVELS, "sd": np.array(SDS), "lower_asymptote": np.array([0.5]), "lapse_rate": np.array(LAPSES)}
    outcomes = {"outcome_domain": {"response": ["Yes", "No"]}, "func": "norm_cdf", "stim_scale": "linear"}
    for _ in range(n_sets):
        answer = person(table, rng)
        rule = questplus.QuestPlus(stim_domain={"intensity": LEVELS}, param_domain=axes, **outcomes)
        for _ in range(N_TRIALS_QUEST):
            level = float(np.asarray(rule.next_stim["intensity"]))
            rule.update(stim={"intensity": level}, outcome={"response": "Yes" if answer(level) else "No"})


def compare(n_sets: int, n_peers: int) -> None:
    pairs = {
        f"staircase, {N_TRIALS} trials: StairHandler": (partial(ours, STAIRCASE, N_TRIALS), stair_handlers, n_peers),
        f"QUEST+, {N_TRIALS_QUEST} trials: questplus": (
            partial(ours, quest_plus(), N_TRIALS_QUEST),
            questplus_package,
            max(2, n_peers // 5),
        ),
    }
    for table, suffix in ((None, ""), (TABLE, ", with a table of levels")):
        for name, (mine, peer, n) in pairs.items():
            mine(10, table)
            peer(1, table)
            ratio = (run_once(partial(peer, n, table))[0] / n) / (run_once(partial(mine, n_sets, table))[0] / n_sets)
            tell(f"sessions a second of one core, {name}{suffix}", ratio, at_least=20)


def fit_some(numbers: range) -> float:
    """Return the processor time of several batches, after compilation."""
    list(fitted_tracks(STAIRCASE, PEOPLE, (ENDLESS,), 1, n_trials=N_TRIALS))
    return run_once(lambda: list(fitted_tracks(STAIRCASE, PEOPLE, numbers, 1, n_trials=N_TRIALS)))[0]


def fits(n_batches: int) -> None:
    shares = [range(n_batches), range(n_batches, 2 * n_batches)]
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        list(pool.map(fit_some, (range(0), range(0))))  # both processes have compiled
        took_s, busy_s = [], []
        for jobs in (shares[:1], shares):
            began_s = time.perf_counter()
            busy_s.append(sum(pool.map(fit_some, jobs)))
            took_s.append(time.perf_counter() - began_s)
    both_us = 1e6 * busy_s[1] / (2 * n_batches * BATCH)
    name = "1e6 tracks with a mode fit on two cores, from some batches: processor time of each core"
    tell(name, both_us / 2, "s", at_most=60)
    tell("two processes, of twice one, by processor time", 2 * busy_s[0] / busy_s[1], at_least=0.85)
    tell("two processes, of twice one, by the clock", took_s[0] / took_s[1])


def write(n_tracks: int, n_jobs: int, out: Path) -> None:
    """Write all tracks, in processes whose import times count."""
    run, began_s = TrackRun(STAIRCASE, PEOPLE, math.ceil(n_tracks / BATCH), 1, n_trials=N_TRIALS), time.perf_counter()
    with workers(n_jobs) as spread:
        paths = list(write_tracks(run, out, resume=True, spread=spread))
    took_s, size = time.perf_counter() - began_s, sum(path.stat().st_size for path in paths)
    n_rows = sum(parquet.read_metadata(path).num_rows for path in paths)
    most_mb = max(resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)) / 1024
    print(f"{n_rows} tracks of {N_TRIALS} trials, fitted, in {len(paths)} files of {size / 1e6:.0f} MB in all")
    print(
        f"{took_s:.1f} s by the clock on {n_jobs} processes of at most {most_mb:.0f} MiB; load {os.getloadavg()[0]:.1f}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    for name, default in (("tracks", None), ("jobs", 2), ("sets", 2000), ("peers", 20), ("batches", 4)):
        parser.add_argument(f"--{name}", type=int, default=default)
    parser.add_argument("--out", type=Path)
    arguments = parser.parse_args()
    if arguments.tracks is not None:
        with TemporaryDirectory() as folder:
            write(arguments.tracks, arguments.jobs, arguments.out or Path(folder))
        return
    warnings.simplefilter("ignore")  # warnings of the other programs' imports
    compare(arguments.sets, arguments.peers)
    fits(arguments.batches)


if __name__ == "__main__":
    main()
