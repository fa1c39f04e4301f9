"""Loss of amplitude by condition."""

from collections.abc import Iterator

from ...figures.psychophysics import loss_figure
from ...result import Analysis
from ...wording import cross_table
from ..section import Figure, Lead, ResultKind, Section, TextTable, grid, rows_of


def _sections(analysis: Analysis) -> Iterator[Section]:
    if "loss" in analysis.tables:
        table = analysis.tables["loss"]
        has_interval = bool(table["mean_low"].notna().any())
        over = "participants" if table["n"].max() > 1 else "readings of one participant"
        within = f", with 95 % interval over {over}" if has_interval else ""
        lead = Lead(f"Mean loss, 1 − measured / stated amplitude{within}.")
        bars = "; bars are 95 % t-intervals" if has_interval else ""
        drawing = loss_figure(table, analysis.factors)
        figure = Figure("loss", drawing, f"Loss of amplitude: means over {over}{bars}.", table="loss")
        crossed = grid(cross_table(table, analysis.factors), analysis.factors)
        yield Section("Loss of amplitude", (lead, crossed, figure))


def _terminal(analysis: Analysis) -> Iterator[TextTable]:
    if "loss" in analysis.tables:
        table = analysis.tables["loss"]
        over = "participants" if table["n"].max() > 1 else "readings"
        interval = f", 95 % interval over {over}" if table["mean_low"].notna().any() else ""
        yield TextTable(cross_table(table, analysis.factors), f"loss of amplitude (mean{interval})")


KIND = ResultKind(_sections, _terminal, rows_of("loss"))
