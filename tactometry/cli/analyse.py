"""`tactometry analyse`."""

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from .output import data_argument, path_option, say, subcommand

if TYPE_CHECKING:
    from tactometry.analysis.result import Analysis


@subcommand("analyse demo --report demo/report.html")
@data_argument
@path_option("--report", metavar="FILE.html", help="Write a report (HTML) and its tables.")
@click.option("--pdf", is_flag=True, help="Also write the report as a PDF.")
@click.option("--within", metavar="A,B", help="Factors, or '' for none; default: columns between trial and procedure.")
@path_option("--columns", metavar="MAP.toml", help="Column map of a table that Tactometry did not write.")
@click.option(
    "--level-scale",
    type=click.Choice(("linear", "log10", "db")),
    help="Scale of the levels in the fit: as recorded, log10, or decibels.",
)
@path_option("--plan", metavar="PLAN.toml", help="Analysis plan: exclusions and margins of equivalence.")
@path_option("--figures", metavar="DIR", help="Write every figure as SVG and PNG, with its data.")
@click.option("--jobs", "n_jobs", type=int, default=1, help="Number of processes; -1 uses all cores.")
def command(
    path: Path,
    report: Path | None,
    within: str | None,
    columns: Path | None,
    level_scale: str | None,
    plan: Path | None,
    figures: Path | None,
    *,
    pdf: bool,
    n_jobs: int,
) -> None:
    """Estimate thresholds, group means and ANOVA of a data set or file PATH."""
    from tactometry.analysis.pipeline import analyse
    from tactometry.analysis.plan import read_plan
    from tactometry.analysis.reading.column_map import read_column_map
    from tactometry.analysis.report.summary import summary
    from tactometry.experiments.data_sets.rule_estimates import replay_of
    from tactometry.experiments.data_sets.session_files import edit_warnings
    from tactometry.experiments.data_sets.touch_courses import touch_courses
    from tactometry.experiments.workers import check_workers, workers

    check_workers(n_jobs, None)
    factors = None if within is None else [name.strip() for name in within.split(",") if name.strip()]
    with workers(n_jobs) as spread:
        analysis = analyse(
            path,
            report=report,
            pdf=pdf,
            within=factors,
            column_map=None if columns is None else read_column_map(columns),
            level_scale=level_scale,
            plan=None if plan is None else read_plan(plan),
            figures=figures,
            warnings=edit_warnings(path),
            replay=replay_of(path),
            touches=partial(touch_courses, path),
            spread=spread,
        )
    say(summary_text(analysis), summary(analysis))


def summary_text(analysis: "Analysis") -> str:
    """Return warnings, group tables and ANOVA tables for a terminal."""
    from rich.console import Console

    from tactometry.analysis.report.terminal import tables

    console = Console(width=None)
    with console.capture() as capture:
        for warning in analysis.warnings:
            console.print(f"! {warning}", markup=False, highlight=False)
        for table, sentences in tables(analysis, console.width):
            if table is not None:
                console.print(table)
            for sentence in sentences:
                console.print(sentence, markup=False, highlight=False)
        if analysis.figures_folder is not None:
            console.print(f"figures: {analysis.figures_folder}", markup=False, soft_wrap=True)
        if analysis.report is not None:
            console.print(f"report: {analysis.report}\ntables: {analysis.tables_folder}", markup=False, soft_wrap=True)
        if analysis.pdf is not None:
            console.print(f"PDF: {analysis.pdf}", markup=False, soft_wrap=True)
    return capture.get().rstrip("\n")
