"""A study of 10 people, 21 conditions and 60 trials in each, simulated and analysed: `python benchmarks/study.py`.

Prints the seconds, of processor and of wall, of each step in memory (sessions, fits, analysis of variance), and of the
same study with a data set, its figures and its report.
"""

import platform
import tempfile
from collections.abc import Callable
from contextlib import contextmanager
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

from tactometry.analysis.outcomes.outcome import outcome
from tactometry.analysis.pipeline import analyse
from tactometry.analysis.reading.trials import used_rows
from tactometry.analysis.tasks import cells
from tactometry.experiments.data_sets.rule_estimates import replay_of
from tactometry.experiments.sessions.in_memory import simulated_trials
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


def in_memory(root: Path) -> Steps:
    steps: Steps = {}
    made = simulation(root)
    with timed(steps, "sessions"):
        trials = simulated_trials(made.experiment(), made.sessions())
    with timed(steps, "fits"):
        answers = cells.counted_answers(cells.judgements(used_rows(trials)))
        every = cells.cells(answers, trials.factors)
        unit = cells.level_unit(trials)
        estimates = cells.estimates(every, cells.n_alternatives(trials), unit)
        table = cells.estimate_table(estimates, trials.factors, unit)
    with timed(steps, "analysis of variance"):
        outcome(table, list(trials.factors), "yes_no", "threshold")
    print(f"{len(trials.rows)} trials, {len(every)} cells")
    return steps


def on_disk(root: Path) -> Steps:
    steps: Steps = {}
    with timed(steps, "simulate"):
        list(simulate(simulation(root)))
    with timed(steps, "analyse --report --figures"):
        analyse(root, report=root / "report.html", figures=root / "figures", replay=replay_of(root))
    return steps


def report(way: str, measure: Callable[[Path], Steps], *where: Any) -> None:
    steps = measure(*where)
    steps["together"] = tuple(map(sum, zip(*steps.values(), strict=True)))  # type: ignore[assignment]
    for name, (cpu, wall) in steps.items():
        print(f"{way:<10} {name:<28} {cpu:>7.2f} s of processor {wall:>7.2f} s of wall")


def main() -> None:
    print(f"Python {platform.python_version()}, {platform.machine()}, one process")
    with tempfile.TemporaryDirectory() as folder:
        report("in memory", in_memory, Path(folder) / "nowhere")
        report("on disk", on_disk, Path(folder) / "data set")


if __name__ == "__main__":
    main()
