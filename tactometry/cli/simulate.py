"""`tactometry simulate` and `tactometry demo`."""

from dataclasses import asdict
from pathlib import Path
from typing import Any

import click

from tactometry.experiments.sessions.simulation import Simulation, simulate as sessions_of
from tactometry.experiments.study.experiment import Experiment, wire
from tactometry.experiments.study.study_file import folder_of, load, parse
from tactometry.experiments.workers import check_workers

from ..errors import count_of
from .output import STUDY, allow_code_option, allow_erased_option, drawn_seed, path_option, progress, say, subcommand

DEMO_STUDY = "electrovibration-threshold"
N_PARTICIPANTS = 10


@subcommand("simulate tutorial --participants 5 --seed 1 --out simulated")
@click.argument("study", type=STUDY)
@click.option("--participants", "n_participants", type=int, required=True, help="Number of participants, from P01.")
@click.option("--seed", type=int, help="Seed, which determines all results; default: a new one, which is printed.")
@path_option("--out", required=True, help="Folder of the data set.")
@click.option("--resume", is_flag=True, help="Continue an interrupted simulation.")
@click.option("--jobs", "n_jobs", type=int, default=1, help="Number of processes; -1 uses all cores.")
@click.option("--scheduler", help="Address of a Dask scheduler (extra: cluster).")
@allow_code_option
@allow_erased_option
@click.option("--explain", is_flag=True, help="Also print which effects can be felt and which are not modelled.")
def simulate(
    study: str,
    n_participants: int,
    seed: int | None,
    out: Path,
    *,
    resume: bool,
    n_jobs: int,
    scheduler: str | None,
    allow_code: bool,
    allow_erased: bool,
    explain: bool,
) -> None:
    """Run STUDY (a built-in name or a path) with simulated participants."""
    check_workers(n_jobs, scheduler)
    _, content = load(study)
    code_from = folder_of(study) if allow_code else None
    seed = drawn_seed(seed, resume=resume)
    simulation = Simulation(content, study, out, n_participants, seed, resume, code_from, allow_erased)
    sessions = sessions_of(simulation, n_jobs=n_jobs, scheduler=scheduler)
    recorded = list(progress(sessions, len(simulation.sessions()), "simulating"))
    for session in recorded:
        if session.repaired:
            click.echo(session.repaired, err=True)
    n_trials = sum(session.n_trials for session in recorded)
    n_aborted = sum(session.endings.get("aborted", 0) for session in recorded)
    result = {"data_set": str(out), "participants": n_participants, "trials": n_trials, "seed": seed}
    aborted = f", {count_of(n_aborted, 'procedure')} aborted" if n_aborted else ""
    n_missed = sum(session.practice_missed for session in recorded)
    missed = f", {count_of(n_missed, 'practice')} without its criterion" if n_missed else ""
    text = f"{out}: {count_of(n_participants, 'simulated participant')}, {count_of(n_trials, 'trial')}{aborted}{missed}"
    experiment = wire(parse(content, study), study, code_from)
    lines, record = _predictions(experiment, explain=explain)
    say("\n".join([text, *lines]), {**result, "aborted": n_aborted, "practice_missed": n_missed, **record})


def _predictions(experiment: Experiment, *, explain: bool) -> tuple[list[str], dict[str, Any]]:
    """Return text and JSON of weak conditions, or of all predictions."""
    if explain:
        from tactometry.experiments.study.felt_effects import predict

        predicted = predict(experiment)
        return predicted.lines, predicted.record
    from tactometry.experiments.study.predictions import unfelt

    too_weak = list(unfelt(experiment, simulated=True))
    return [one.line for one in too_weak], {"unfelt": [asdict(one) for one in too_weak]} if too_weak else {}


@subcommand("demo --out demo --seed 1")
@path_option("--out", default=Path("demo"), help="Folder of the data set.")
@click.option("--seed", type=click.IntRange(min=0), default=1, help="Seed, which determines all results.")
def demo(out: Path, seed: int) -> None:
    """Simulate a threshold study, analyse it and write the report."""
    from tactometry.analysis.pipeline import analyse
    from tactometry.analysis.report.summary import summary
    from tactometry.experiments.data_sets.rule_estimates import replay_of

    from .analyse import summary_text

    _, content = load(DEMO_STUDY)
    simulation = Simulation(content, DEMO_STUDY, out, N_PARTICIPANTS, seed, resume=True)
    sessions = list(progress(sessions_of(simulation), N_PARTICIPANTS, "simulating"))
    analysis = analyse(out, report=out / "report.html", replay=replay_of(out))
    n_trials = sum(session.n_trials for session in sessions)
    where = f"data set: {out} ({N_PARTICIPANTS} simulated participants, {n_trials} trials)"
    say(f"{summary_text(analysis)}\n{where}", {"data_set": str(out), "trials": n_trials, **summary(analysis)})
