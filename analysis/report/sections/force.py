"""Applied force by condition."""

from collections.abc import Iterator

from ...figures.psychophysics import threshold_figure
from ...outcomes.findings import FORCE as TARGET
from ...result import Analysis
from ...wording import cross_table
from ..captions import figure_text
from ..section import Figure, Lead, ResultKind, Section, TextTable, grid, rows_of


def _sections(analysis: Analysis) -> Iterator[Section]:
    if "force" in analysis.tables:
        table = analysis.tables["force"]
        spread = " over participants ± standard deviation between them" if table["mean_low"].notna().any() else ""
        lead = Lead(f"Mean applied force{spread}, and time in the target band where it was measured.")
        crossed = grid(cross_table(table, analysis.factors), analysis.factors)
        yield Section("Applied force", (lead, crossed, _figure(analysis)))


def _figure(analysis: Analysis) -> Figure:
    table, individuals = analysis.tables["force"], analysis.tables["force_participants"]
    stated = [] if analysis.study.force_n is None else [analysis.study.force_n]
    targets = sorted(set(individuals[TARGET].astype(float))) if TARGET in analysis.factors else stated
    values = table, individuals, analysis.factors, "force_mean_n"
    drawing = threshold_figure(*values, "Mean applied force (N)", targets=targets, from_zero=True)
    dashed = f"; dashed: {'the target' if len(targets) == 1 else 'targets'}" if targets else ""
    text = f"Mean applied force: {figure_text(table, 'faint dots are participants')}{dashed}."
    return Figure("force", drawing, text, "force")


def _terminal(analysis: Analysis) -> Iterator[TextTable]:
    if "force" in analysis.tables:
        table = analysis.tables["force"]
        spread = " ± SD between participants" if table["mean_low"].notna().any() else ""
        yield TextTable(cross_table(table, analysis.factors), f"applied force (mean{spread})")


KIND = ResultKind(_sections, _terminal, rows_of("force"))
