"""`tactometry check`."""

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from .hands_off import hands_are_off, hands_off_option
from .output import json_option, say

if TYPE_CHECKING:
    from tactometry.experiments.bench.finding import Finding

LONGEST_CELL = 50
"""A sentence that is longer stands below the table, whose cells fold on a narrow terminal."""
MARKS = {True: "ok", False: "NOT FINE", None: ""}


@click.command(name="check", epilog="Example: tactometry check electrovibration-threshold --bench bench.toml")
@click.argument("study", required=False)
@click.option("--bench", "bench_path", type=click.Path(path_type=Path), help="Bench file (TOML).")
@click.option(
    "--out", type=click.Path(path_type=Path), default=Path(), help="Where data would be written; default here."
)
@hands_off_option
@json_option
@click.pass_context
def command(
    ctx: click.Context, study: str | None, bench_path: Path | None, out: Path, *, hands_off: bool, as_json: bool
) -> None:
    """Try what a session of STUDY needs: computer, disk, display, sensors, and the output with a test tone.

    The tone stays at a tenth of the voltage limit. An output that leads to an amplifier plays it only after somebody
    said that hands are off: with --hands-off, or in words at the terminal. Exit status 1 if something is not fine, 3 if
    that is a device.
    """
    from tactometry.experiments.bench.bench_file import load_bench
    from tactometry.experiments.bench.finding import exit_status
    from tactometry.experiments.bench.preflight import check

    bench = load_bench(bench_path)
    sure = hands_off or (bench.output.settings.connected and hands_are_off())
    findings = check(study, bench, out, hands_off=sure)
    status = exit_status(findings)
    say(_table(findings), {"fine": status == 0, "findings": [asdict(each) for each in findings]}, as_json=as_json)
    ctx.exit(status)


def _table(findings: "list[Finding]") -> str:
    from rich.console import Console
    from rich.table import Column, Table

    table = Table(*(Column(name, overflow="fold") for name in ("part", "what", "found", "expected", "")))
    told = [each for each in findings if len(each.found) > LONGEST_CELL]
    for each in findings:
        found = "see below" if each in told else each.found
        table.add_row(each.part, each.what, found, each.expected, MARKS[each.fine])
    console = Console()
    with console.capture() as capture:
        console.print(table, markup=False, highlight=False)
    n_bad = sum(each.fine is False for each in findings)
    sentences = [f"{each.part}: {each.found}" for each in told]
    return "\n".join([capture.get().rstrip(), *sentences, "everything is fine" if n_bad == 0 else f"{n_bad} not fine"])
