"""`tactometry check`."""

from dataclasses import asdict
from pathlib import Path

import click
from rich.console import Console
from rich.table import Column, Table

from tactometry.experiments.bench.bench_file import load_bench
from tactometry.experiments.bench.preflight import check
from tactometry.experiments.bench.preflight_checks import Finding, exit_status

from .output import (
    STUDY,
    allow_code_option,
    bench_option,
    hands_are_off,
    hands_off_option,
    path_option,
    say,
    subcommand,
)

LONGEST_CELL = 50
"""Longer texts are printed below the table, whose cells wrap on a narrow terminal."""
MARKS = {True: "ok", False: "FAILED", None: ""}


@subcommand("check electrovibration-threshold --bench bench.toml")
@click.argument("study", type=STUDY, required=False)
@bench_option
@path_option("--out", default=Path(), help="Folder of the data; default: the working directory.")
@hands_off_option
@allow_code_option
def command(study: str | None, bench_path: Path | None, out: Path, *, hands_off: bool, allow_code: bool) -> int:
    """Check computer, disk, display, sensors and output for STUDY.

    The test tone has a tenth of the voltage limit. An output with an amplifier plays the tone only after --hands-off or
    your confirmation at the terminal. Exit status 1 if a check fails, 3 if a device fails.
    """
    bench = load_bench(bench_path)
    sure = hands_off or (bench.output.settings.connected and hands_are_off())
    findings = check(study, bench, out, hands_off=sure, allow_code=allow_code)
    status = exit_status(findings)
    say(_table(findings), {"fine": status == 0, "findings": [asdict(finding) for finding in findings]})
    return status


def _table(findings: list[Finding]) -> str:
    table = Table(*(Column(name, overflow="fold") for name in ("part", "what", "found", "expected", "")))
    long = [finding for finding in findings if len(finding.found) > LONGEST_CELL]
    for finding in findings:
        cell = "see below" if finding in long else finding.found
        table.add_row(finding.part, finding.what, cell, finding.expected, MARKS[finding.fine])
    console = Console()
    with console.capture() as capture:
        console.print(table, markup=False, highlight=False)
    n_bad = sum(finding.fine is False for finding in findings)
    sentences = [f"{finding.part}: {finding.found}" for finding in long]
    return "\n".join([capture.get().rstrip(), *sentences, "all checks passed" if n_bad == 0 else f"{n_bad} failed"])
