"""A study of 10 people, 21 conditions and 60 trials in each, simulated and analysed: `python benchmarks/study.py`.

Prints the seconds, of processor and of wall, of each step in memory (sessions, fits, analysis of variance), and of the
same study with a data set, its figures and its report; in one process, and with sessions on two, which are started
first, and stand the second time. The seconds of processor are those of this process. Asked: 5 s of wall in memory, 20 s
with the data set, on two cores.
"""

import os
import platform
import tempfile
from collections.abc import Callable
from contextlib import contextmanager
from pathlib import Path
from time import perf_counter, process_time

from measured import tell

from tactometry.analysis.outcomes.outcome import outcome
from tactometry.analysis.pipeline import analyse
from tactometry.analysis.reading.trials import used_rows
from tactometry.analysis.tasks import cells
from tactometry.experiments.data_sets.rule_estimates import replay_of
from tactometry.experiments.sessions.in_memory import trials_of
from tactometry.experiments.sessions.simulation import Simulation, simulate
from tactometry.experiments.study.study_file import load

STUDY = "electrovibration-threshold"
N_PARTICIPANTS = 10
LONGER = {b"n_reversals = 14": b"n_reversals = 60", b"n_trials = 40": b"n_trials = 48"}
"""48 trials with a level, and a catch trial after each four of them."""
Steps = dict[str, tuple[float, float]]


@contextmanager
def timed(steps: Steps, name: str):
    cpu, wall = process_time(), perf_counter()
    yield
    steps[name] = process_time() - cpu, perf_counter() - wall


def simulation(root: Path) -> Simulation:
    _, content = load(STUDY)
    for shorter, longer in LONGER.items():
        assert shorter in content, f"{STUDY} states no {shorter.decode()}"
        content = content.replace(shorter, longer)
    return Simulation(content, STUDY, root, N_PARTICIPANTS, seed=1)


def in_memory(root: Path, n_jobs: int) -> Steps:
    steps: Steps = {}
    with timed(steps, "sessions"):
        trials = trials_of(simulation(root), n_jobs=n_jobs)
    with timed(steps, "fits"):
        answers = cells.counted_answers(cells.judgements(used_rows(trials)))
        every = cells.cells(answers, trials.factors)
        unit = cells.level_unit(trials)
        estimates = cells.estimates(every, unit)
        table = cells.estimate_table(estimates, trials.factors, unit)
    with timed(steps, "analysis of variance"):
        outcome(table, list(trials.factors), "yes_no", "threshold")
    assert len(every) == 210
    return steps


def on_disk(root: Path, n_jobs: int) -> Steps:
    steps: Steps = {}
    with timed(steps, "simulate"):
        list(simulate(simulation(root), n_jobs=n_jobs))
    with timed(steps, "analyse --report --figures"):
        analyse(root, report=root / "report.html", figures=root / "figures", replay=replay_of(root))
    return steps


def report(
    way: str, measure: Callable[[Path, int], Steps], root: Path, n_jobs: int, at_most_s: float | None = None
) -> None:
    steps = measure(root, n_jobs)
    steps["together"] = tuple(map(sum, zip(*steps.values(), strict=True)))  # type: ignore[assignment]
    for name, (cpu, wall) in steps.items():
        print(f"{way:<32} {name:<28} {cpu:>7.2f} s of processor {wall:>7.2f} s of wall")
    tell(f"{way}, by the clock", steps["together"][1], "s", at_most=at_most_s)


def main() -> None:
    print(f"Python {platform.python_version()}, {platform.machine()}, load {os.getloadavg()[0]:.1f}")
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        report("in memory, one process", in_memory, root, 1)
        report("in memory, two are started", in_memory, root, 2, at_most_s=5)
        report("in memory, two that stand", in_memory, root, 2)
        report("data set, one process", on_disk, root / "one", 1)
        report("data set, two that stand", on_disk, root / "two", 2, at_most_s=20)


if __name__ == "__main__":
    main()
