"""Time a study of 10 participants, simulated and analysed.

The study has 21 conditions with 60 trials each: `python benchmarks/study.py`. It is timed in memory (sessions, fits,
analysis of variance), and with a data set, figures and report. Sessions run in one process, or in two processes, cold
and warm. Times are wall-clock times.
"""

import tempfile
from collections.abc import Callable
from pathlib import Path
from time import perf_counter

from tactometry.analysis.outcomes.outcome import outcome
from tactometry.analysis.pipeline import analyse
from tactometry.analysis.reading.trials import used_rows
from tactometry.analysis.tasks import cells
from tactometry.experiments.data_sets.rule_estimates import replay_of
from tactometry.experiments.harness import tell
from tactometry.experiments.sessions.in_memory import trials_of
from tactometry.experiments.sessions.simulation import Simulation, simulate
from tactometry.experiments.study.study_file import load

STUDY, N_PARTICIPANTS = "electrovibration-threshold", 10
LONGER = {b"n_reversals = 14": b"n_reversals = 60", b"n_trials = 40": b"n_trials = 48"}
"""48 trials with a level, and one catch trial for each four of them."""


def simulation(root: Path) -> Simulation:
    _, content = load(STUDY)
    for shorter, longer in LONGER.items():
        assert shorter in content, f"{STUDY} states no {shorter.decode()}"
        content = content.replace(shorter, longer)
    return Simulation(content, STUDY, root, N_PARTICIPANTS, seed=1)


def in_memory(root: Path, n_jobs: int) -> None:
    trials = trials_of(simulation(root), n_jobs=n_jobs)
    answers = cells.counted_answers(cells.judgements(used_rows(trials)))
    every, unit = cells.cells(answers, trials.factors), cells.level_unit(trials)
    assert len(every) == 210
    table = cells.estimate_table(cells.estimates(every, unit), trials.factors, unit)
    outcome(table, list(trials.factors), "yes_no", "threshold")


def on_disk(root: Path, n_jobs: int) -> None:
    list(simulate(simulation(root), n_jobs=n_jobs))
    analyse(root, report=root / "report.html", figures=root / "figures", replay=replay_of(root))


def report(name: str, measure: Callable[[Path, int], None], n_jobs: int, at_most_s: float | None = None) -> None:
    with tempfile.TemporaryDirectory() as folder:
        began_s = perf_counter()
        measure(Path(folder) / "study", n_jobs)
        tell(f"{name}, by the clock", perf_counter() - began_s, "s", at_most=at_most_s)


if __name__ == "__main__":
    report("in memory, one process", in_memory, 1)
    report("in memory, two are started", in_memory, 2, at_most_s=5)
    report("in memory, two that stand", in_memory, 2)
    report("data set, one process", on_disk, 1)
    report("data set, two that stand", on_disk, 2, at_most_s=20)
