"""Sessions per second in batches, beside the same study as a plain loop with PsychoPy's StairHandler and with the
package questplus; and tracks of 140 trials with a mode fit each, in one process and in two.

Run: OMP_NUM_THREADS=1 python benchmarks/batch.py [--sets 2000] [--peers 20] [--batches 4]. Times are of the processor,
of one core; ratios are of one run, ours and theirs in turn, after imports and compilation. A `table` gives the
sensation level of each level of the stimulus, as a scene's table does. Two processes are compared with one by processor
time, and by the wall clock too: on a machine that does other work that ratio tells of this work as well.

With --tracks 1000000 [--out DIR] [--jobs 2] instead: so many tracks, fitted and written to Parquet, whole. A run with
--out that was killed goes on.
"""

import argparse
import math
import os
import resource
import sys
import time
import warnings
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from measured import tell
from pyarrow import parquet

from tactometry.experiments.census.batches import BATCH, Respondents, fitted_tracks
from tactometry.experiments.census.chunks import TrackRun, write_chunk, write_tracks
from tactometry.protocols import ParameterGrid, QuestPlus, Staircase
from tactometry.protocols.batch.answers import LevelTable, criteria
from tactometry.protocols.batch.tracks import tracks
from tactometry.psychometric import shape_named

N_TRIALS, N_TRIALS_QUEST = 140, 60
ENDLESS = 10**6
PEOPLE = Respondents(20.0, 3.0, 8.0, guess_rate=0.5, lapse_rate=0.02)
CURVE = (PEOPLE.width, PEOPLE.guess_rate, PEOPLE.lapse_rate)
LEVELS = np.linspace(0.0, 40.0, 41)
TABLE = LevelTable(LEVELS, LEVELS - 0.002 * (LEVELS - 20.0) ** 2)
STAIRCASE = Staircase(36.0, (8.0, 4.0, 2.0), 0.0, 40.0, n_reversals=ENDLESS, n_trials=N_TRIALS, n_at_bound=ENDLESS)
SDS = (1.2, 1.8, 2.7, 4.0, 6.0)
LAPSES = (0.0, 0.02, 0.05)


def quest_plus() -> QuestPlus:
    widths = tuple(shape_named("normal").z_width * sd for sd in SDS)
    grid = ParameterGrid(tuple(LEVELS.tolist()), widths, (0.5,), LAPSES, "normal")
    return QuestPlus(tuple(LEVELS.tolist()), grid, N_TRIALS_QUEST)


def ours(rule: Staircase | QuestPlus, n_sets: int, n_trials: int, table: LevelTable | None) -> None:
    rng = np.random.default_rng()
    thresholds = PEOPLE.threshold + PEOPLE.threshold_sd * rng.standard_normal((n_sets, 1))
    tracks(rule, criteria(rng.random((n_sets, n_trials)), PEOPLE.shape, thresholds, *CURVE), table)


def chance_of(table: LevelTable | None, rng: np.random.Generator) -> Callable[[float], float]:
    """Of one person, at a level."""
    threshold = PEOPLE.threshold + PEOPLE.threshold_sd * float(rng.standard_normal())
    curve, (width, guess, lapse) = shape_named(PEOPLE.shape), CURVE

    def chance(level: float) -> float:
        """The Gumbel function in closed form, as fast as Python has it."""
        felt = level if table is None else float(np.interp(level, table.levels, table.felt[0]))
        z = curve.z50 + (felt - threshold) / width * curve.z_width
        return guess + (1 - guess - lapse) * -math.expm1(-math.exp(z))

    return chance


def stair_handlers(n_sets: int, table: LevelTable | None) -> None:
    from psychopy.data import StairHandler

    rng = np.random.default_rng()
    for _ in range(n_sets):
        chance = chance_of(table, rng)
        stairs = StairHandler(
            36.0, nReversals=1, stepSizes=[8, 4, 2], nTrials=N_TRIALS, nUp=1, nDown=2, minVal=0, maxVal=40,
            stepType="lin", autoLog=False,
        )  # fmt: skip
        for level in stairs:
            stairs.addResponse(int(rng.random() < chance(level)))


def questplus_package(n_sets: int, table: LevelTable | None) -> None:
    import questplus

    rng = np.random.default_rng()
    axes = {"mean": LEVELS, "sd": np.array(SDS), "lower_asymptote": np.array([0.5]), "lapse_rate": np.array(LAPSES)}
    for _ in range(n_sets):
        chance = chance_of(table, rng)
        rule = questplus.QuestPlus(
            stim_domain={"intensity": LEVELS},
            param_domain=axes,
            outcome_domain={"response": ["Yes", "No"]},
            func="norm_cdf",
            stim_scale="linear",
        )
        for _ in range(N_TRIALS_QUEST):
            level = float(np.asarray(rule.next_stim["intensity"]))
            said = "Yes" if rng.random() < chance(level) else "No"
            rule.update(stim={"intensity": level}, outcome={"response": said})


def per_second(work: Callable[[], None], n_sets: int) -> float:
    began_s = time.process_time()
    work()
    return n_sets / (time.process_time() - began_s)


def compare(n_sets: int, n_peers: int) -> None:
    print(f"{'sessions per second of one core':<44} {'ours':>10} {'theirs':>10} {'ratio':>8}")
    quest = quest_plus()
    for table, told in ((None, ""), (TABLE, ", with a table of levels")):
        pairs = (
            (f"staircase, {N_TRIALS} trials: StairHandler", STAIRCASE, N_TRIALS, stair_handlers, n_peers),
            (
                f"QUEST+, {N_TRIALS_QUEST} trials: questplus",
                quest,
                N_TRIALS_QUEST,
                questplus_package,
                max(2, n_peers // 5),
            ),
        )
        for name, rule, n_trials, peer, n in pairs:
            ours(rule, 10, n_trials, table)
            mine = per_second(lambda r=rule, m=n_trials, t=table: ours(r, n_sets, m, t), n_sets)
            peer(1, table)
            theirs = per_second(lambda p=peer, k=n, t=table: p(k, t), n)
            print(f"{name + told:<60} {mine:>10.0f} {theirs:>10.2f} {mine / theirs:>8.0f}", flush=True)
            tell(f"sessions a second of one core, {name}{told}", mine / theirs, at_least=20)


def fit_some(numbers: range) -> float:
    """Processor time of some batches, after compilation."""
    for _ in fitted_tracks(STAIRCASE, PEOPLE, (10**6,), 1, n_trials=N_TRIALS):
        began_s = time.process_time()
    for _ in fitted_tracks(STAIRCASE, PEOPLE, numbers, 1, n_trials=N_TRIALS):
        pass
    return time.process_time() - began_s


def fits(n_batches: int) -> None:
    shares = [range(n_batches), range(n_batches, 2 * n_batches)]
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        list(pool.map(fit_some, (range(0), range(0))))  # both have compiled
        began_s = time.perf_counter()
        (alone_s,) = pool.map(fit_some, shares[:1])
        one_s = time.perf_counter() - began_s
        began_s = time.perf_counter()
        busy_s = sum(pool.map(fit_some, shares))
        two_s = time.perf_counter() - began_s
    each_us, both_us = 1e6 * alone_s / (n_batches * BATCH), 1e6 * busy_s / (2 * n_batches * BATCH)
    print(f"\ntracks of {N_TRIALS} trials with a mode fit: {each_us:.0f} us of the processor each")
    tell("1e6 tracks with a mode fit on two cores, from some batches: processor time of each core", both_us / 2, "s",
         at_most=60)  # fmt: skip
    tell("two processes, of twice one, by processor time", each_us / both_us, at_least=0.85)
    tell("two processes, of twice one, by the clock", one_s / two_s)


def told_chunk(job: tuple[TrackRun, range, Path]) -> tuple[Path, int, float, int]:
    """A chunk; who made it, in how many seconds of processor time so far, and its most memory (KiB)."""
    path = write_chunk(job)
    return path, os.getpid(), time.process_time(), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def whole(n_tracks: int, n_jobs: int, out: Path) -> None:
    """All tracks, on processes that are begun for it: their imports count."""
    run = TrackRun(STAIRCASE, PEOPLE, math.ceil(n_tracks / BATCH), 1, n_trials=N_TRIALS)
    busy_s: dict[int, float] = {}
    memory_kib: dict[int, int] = {}

    def spread(function: Callable[..., Path], jobs: Iterable[tuple[TrackRun, range, Path]]) -> Iterator[Path]:
        assert function is write_chunk
        with ProcessPoolExecutor(n_jobs, mp_context=get_context("spawn")) as pool:
            for path, who, so_far_s, most_kib in pool.map(told_chunk, jobs):
                busy_s[who], memory_kib[who] = so_far_s, most_kib
                print(f"\r{path.name}", end="", file=sys.stderr, flush=True)
                yield path

    began_s = time.perf_counter()
    paths = list(write_tracks(run, out, resume=True, spread=spread))
    took_s, size = time.perf_counter() - began_s, sum(path.stat().st_size for path in paths)
    n_rows = sum(parquet.read_metadata(path).num_rows for path in paths)
    print(f"\n{n_rows} tracks of {N_TRIALS} trials, fitted, in {len(paths)} files of {size / 1e6:.0f} MB in all")
    print(f"{took_s:.1f} s by the clock on {n_jobs} processes; load {os.getloadavg()[0]:.1f}")
    print(
        f"{sum(busy_s.values()):.1f} s of the processor, {', '.join(f'{each:.1f}' for each in busy_s.values())} of each"
    )
    print(f"at most {max(memory_kib.values(), default=0) / 1024:.0f} MiB of a process")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--tracks", type=int)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--out", type=Path)
    parser.add_argument("--sets", type=int, default=2000)
    parser.add_argument("--peers", type=int, default=20)
    parser.add_argument("--batches", type=int, default=4)
    said = parser.parse_args()
    if said.tracks is not None:
        with TemporaryDirectory() as folder:
            whole(said.tracks, said.jobs, said.out or Path(folder))
        return
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of the peers' imports
        compare(said.sets, said.peers)
    fits(said.batches)


if __name__ == "__main__":
    main()
