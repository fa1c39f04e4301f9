"""Loss of amplitude by condition."""

from collections.abc import Iterator

from ...figures.loss import loss_figure
from ...result import Analysis
from ...wording.cross_table import cross_table
from ..grid import grid
from ..section import Figure, Kind, Lead, Section, TableBlock, TextTable, rows_of


def _sections(found: Analysis) -> Iterator[Section]:
    if "loss" in found.tables:
        table, factors = found.tables["loss"], found.trials.factors
        has_interval = bool(table["mean_low"].notna().any())
        over = "participants" if table["n"].max() > 1 else "readings of one participant"
        within = f", with 95 % interval over {over}" if has_interval else ""
        lead = Lead(f"Mean loss, 1 − measured / stated amplitude{within}.")
        bars = "; bars are 95 % t-intervals" if has_interval else ""
        figure = Figure(
            "loss", loss_figure(table, factors), f"Loss of amplitude: means over {over}{bars}.", table="loss"
        )
        yield Section("Loss of amplitude", (lead, TableBlock(grid(cross_table(table, factors), factors)), figure))


def _terminal(found: Analysis) -> Iterator[TextTable]:
    if "loss" in found.tables:
        table = found.tables["loss"]
        over = "participants" if table["n"].max() > 1 else "readings"
        interval = f", 95 % interval over {over}" if table["mean_low"].notna().any() else ""
        yield TextTable(cross_table(table, found.trials.factors), f"loss of amplitude (mean{interval})")


LOSS = Kind(_sections, _terminal, rows_of("loss"))
