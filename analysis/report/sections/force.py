"""Applied force by condition."""

from collections.abc import Iterator

from ...figures.group import threshold_figure
from ...outcomes.findings import FORCE as TARGET
from ...result import Analysis
from ...wording.cross_table import cross_table
from ..captions import figure_text
from ..grid import grid
from ..section import Figure, Kind, Lead, Section, TableBlock, TextTable, rows_of


def _sections(found: Analysis) -> Iterator[Section]:
    if "force" in found.tables:
        table, factors = found.tables["force"], found.trials.factors
        spread = " over participants ± standard deviation between them" if table["mean_low"].notna().any() else ""
        lead = Lead(f"Mean applied force{spread}, and time in the target band where it was measured.")
        yield Section("Applied force", (lead, TableBlock(grid(cross_table(table, factors), factors)), _figure(found)))


def _figure(found: Analysis) -> Figure:
    factors, table, individuals = found.trials.factors, found.tables["force"], found.tables["force_participants"]
    stated = [] if found.study.force_n is None else [found.study.force_n]
    targets = sorted(set(individuals[TARGET].astype(float))) if TARGET in factors else stated
    drawing = threshold_figure(
        table,
        factors,
        label="Mean applied force (N)",
        individuals=individuals,
        dependent="force_mean_n",
        targets=targets,
        from_zero=True,
    )
    dashed = f"; dashed: {'the target' if len(targets) == 1 else 'targets'}" if targets else ""
    text = f"Mean applied force: {figure_text(table, 'faint dots are participants')}{dashed}."
    return Figure("force", drawing, text, "force")


def _terminal(found: Analysis) -> Iterator[TextTable]:
    if "force" in found.tables:
        table = found.tables["force"]
        spread = " ± SD between participants" if table["mean_low"].notna().any() else ""
        yield TextTable(cross_table(table, found.trials.factors), f"applied force (mean{spread})")


FORCE = Kind(_sections, _terminal, rows_of("force"))
