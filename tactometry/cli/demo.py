"""`tactometry demo`."""

from pathlib import Path

import click

from .output import json_option, path_option, progress, say

STUDY = "electrovibration-threshold"
N_PARTICIPANTS = 10


@click.command(epilog="Example: tactometry demo --out demo --seed 1")
@path_option("--out", default=Path("demo"), show_default=True)
@click.option("--seed", type=click.IntRange(min=0), default=1, show_default=True, help="Same seed, same bytes.")
@json_option
def command(out: Path, seed: int) -> None:
    """Simulate ten participants of a threshold study, analyse their data and write the report."""
    from tactometry.analysis.pipeline import analyse
    from tactometry.analysis.report.summary import summary
    from tactometry.experiments.data_sets.rule_estimates import replay_of
    from tactometry.experiments.sessions.simulation import Simulation, simulate
    from tactometry.experiments.study.study_file import load

    from .analyse import summary_text

    _, content = load(STUDY)
    simulation = Simulation(content, STUDY, out, N_PARTICIPANTS, seed, resume=True)
    sessions = list(progress(simulate(simulation), N_PARTICIPANTS, "simulating"))
    analysis = analyse(out, report=out / "report.html", replay=replay_of(out))
    n_trials = sum(session.n_trials for session in sessions)
    where = f"data set: {out} ({N_PARTICIPANTS} simulated participants, {n_trials} trials)"
    say(f"{summary_text(analysis)}\n{where}", {"data_set": str(out), "trials": n_trials, **summary(analysis)})
