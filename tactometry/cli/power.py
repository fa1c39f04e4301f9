"""`tactometry power`."""

import sys
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import click

from tactometry.experiments.power.analysis import Power, power
from tactometry.experiments.power.design import PowerDesign, participants_of, trials_of
from tactometry.experiments.power.effect import parse_effect
from tactometry.experiments.power.files import Batch, Folder, asked
from tactometry.experiments.power.scenario import check_design
from tactometry.experiments.power.summary import table
from tactometry.experiments.study.study_file import folder_of, load
from tactometry.experiments.workers import check_workers, workers

from ..arguments.require import expect
from .output import STUDY, allow_code_option, drawn_seed, path_option, say, subcommand


@subcommand('power tutorial --effect "frequency_hz: 6 dB" --participants 6..12 --seed 1 --out power')
@click.argument("study", type=STUDY)
@click.option(
    "--effect",
    required=True,
    help="'force_n: 2 dB', '... 2 dB SL', '... 1 dB PSE', '... 20 % JND', 'pattern: P1 = 3 dB', 'button: 1 points'.",
)
@click.option("--participants", required=True, help="Numbers of participants: 6..24, 6..24:2 or 8,12,16.")
@click.option("--trials", help="Trials per track, such as 40,60; default: the number of the study.")
@click.option("--target", type=float, default=0.8, help="Target power.")
@click.option("--seed", type=int, help="Seed, which determines all results; default: a new one, which is printed.")
@click.option("--alpha", type=float, default=0.05, help="Significance level.")
@click.option("--precision", type=float, default=0.05, help="Half width of the 95 % confidence interval of the power.")
@click.option("--most", type=int, default=1000, help="Largest number of simulated studies per design.")
@click.option("--dropout", type=float, default=0.0, help="Fraction of participants who leave midway.")
@click.option("--dependent", default="", show_default=False, help="Dependent variable, for tasks with several.")
@path_option("--out", help="Folder for the tables (extra: power).")
@click.option(
    "--keep-data", is_flag=True, help="Also keep the trials of each simulated study, as Parquet (with --out)."
)
@click.option("--resume", is_flag=True, help="Continue an interrupted analysis (with --out).")
@click.option("--jobs", "n_jobs", type=int, default=1, help="Number of processes; -1 uses all cores.")
@click.option("--scheduler", help="Address of a Dask scheduler (extra: cluster).")
@allow_code_option
def command(
    *, study: str, effect: str, participants: str, trials: str | None, out: Path | None, **options: Any
) -> None:
    """Estimate the power to detect an effect by simulating STUDY."""
    n_jobs, scheduler, resume, keep_data = (
        options.pop(name) for name in ("n_jobs", "scheduler", "resume", "keep_data")
    )
    check_workers(n_jobs, scheduler)
    expect(out is not None or not resume, "--resume", "no --out", "the folder of the interrupted analysis")
    expect(out is not None or not keep_data, "--keep-data", "no --out", "a folder for the data")
    _, content = load(study)
    options["seed"] = drawn_seed(options["seed"], resume=resume)
    options["code_from"] = folder_of(study) if options.pop("allow_code") else None
    people, tracks, share = participants_of(participants), trials_of(trials), options.pop("dropout")
    design = PowerDesign(content, study, parse_effect(effect), people, tracks, dropout_share=share, **options)
    design = replace(design, dependent=check_design(design))
    folder = None if out is None else Folder.prepared(out, design, resume=resume, keeps_data=keep_data)
    with workers(n_jobs, scheduler) as spread:
        result = power(design, spread, folder, _tell)
    if out is not None:
        from tactometry.experiments.power.analysis import write_page

        write_page(result, out)
    record = {
        "asked": asked(result.design),
        "points": [asdict(point) for point in result.points],
        "recommendation": result.recommendation,
        "cautions": list(result.cautions),
        "out": None if out is None else str(out),
    }
    say(_text(result, out), record)


def _tell(batch: Batch) -> None:
    if sys.stderr.isatty():
        click.echo(f"\r{batch.case.name}: {batch.end} studies ", nl=False, err=True)


def _text(found: Power, out: Path | None) -> str:
    lines = [
        table(found.points),
        *(f"caution: {words}" for words in found.cautions),
        found.recommendation,
        f"{found.design.dependent} of simulated participants, seed {found.design.seed}",
        *([f"page: {out / 'power.html'}"] if out is not None else []),
    ]
    return "\n".join(lines)
