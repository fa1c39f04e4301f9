"""`tactometry validate-method`."""

from functools import partial
from pathlib import Path
from typing import Any

import click

from tactometry.experiments.validation.checks import CHECKS, check_of
from tactometry.experiments.validation.page import departures, page as page_of
from tactometry.experiments.validation.run import Validated, Validation, validate
from tactometry.experiments.workers import check_workers, workers

from ..arguments.require import expect, one_of
from .output import path_option, progress, say, subcommand, writing

PAGE = "validated.md"


@subcommand("validate-method --out validated --check comparisons --rounds 4")
@path_option("--out", required=True, help="Folder for the page, its figures, tables and outcomes.")
@click.option("--check", "checks", multiple=True, help=f"One of {', '.join(CHECKS)} (default: all).")
@click.option("--rounds", "n_rounds", type=int, default=1, help="Number of simulations of each setting.")
@click.option("--seed", type=int, default=1, help="The same seed gives the same tables.")
@click.option("--resume", is_flag=True, help="Continue an interrupted run, or add rounds.")
@click.option("--jobs", "n_jobs", type=int, default=1, help="Number of processes; -1 uses all cores.")
@click.option("--scheduler", help="Address of a Dask scheduler (extra: cluster).")
@path_option("--page", help="Also write the page here, with its figures in the folder 'validated' next to it.")
def command(
    *, out: Path, checks: tuple[str, ...], n_jobs: int, scheduler: str | None, page: Path | None, **options: Any
) -> None:
    """Validate procedures, fits and tests with simulated participants."""
    check_workers(n_jobs, scheduler)
    resume = options.pop("resume")
    n_rounds, seed = options["n_rounds"], options["seed"]
    expect(n_rounds >= 1, "--rounds", n_rounds, "at least 1")
    expect(seed >= 0, "--seed", seed, "a whole number, at least 0")
    for check in checks:
        one_of("--check", check, tuple(CHECKS))
    validation = Validation(checks=tuple(dict.fromkeys(checks)) or tuple(CHECKS), **options)
    with workers(n_jobs, scheduler) as spread:
        result = validate(validation, out, resume=resume, spread=spread, tell=partial(progress, what="validating"))
    _write(result, out / PAGE, as_pixels=True)
    if page is not None:
        _write(result, page, as_pixels=False)
    record = {
        "asked": result.validation.asked | {"rounds": result.validation.n_rounds},
        "tables": {name: table.to_dict("records") for name, table in result.tables.items()},
        "processor_s": dict(result.seconds),
    }
    say(_text(result, out), record)


def _write(found: Validated, path: Path, *, as_pixels: bool) -> None:
    from tactometry.experiments.validation.figures import FOLDER, write_figures

    write_figures(found, path.parent / FOLDER, as_pixels=as_pixels)
    with writing(path):
        path.write_text(page_of(found), encoding="utf-8")


def _text(found: Validated, out: Path) -> str:
    lines = []
    for name, table in found.tables.items():
        off = departures(table)
        lines.append(f"{name}: {len(table)} rows, {len(off)} outside the stated bounds")
        lines += [
            f"  {', '.join(str(row[key]) for key in check_of(name).keys)}: {row['verdict']}"
            for row in off.to_dict("records")
        ]
    return "\n".join([*lines, f"page: {out / PAGE}"])
