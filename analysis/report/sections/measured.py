"""Measurements by condition: loss of amplitude, and applied force."""

from collections.abc import Iterator
from functools import partial

from ...figures.psychophysics import loss_figure, threshold_figure
from ...outcomes.findings import FORCE as TARGET
from ...result import Analysis
from ...wording import cross_table
from ..captions import figure_text
from ..section import Figure, Lead, ResultKind, Section, TextTable, grid, rows_of


def _sections(analysis: Analysis) -> Iterator[Section]:
    for name, section in (("loss", _loss), ("force", _force)):
        if name in analysis.tables:
            title, lead, figure = section(analysis)
            crossed = grid(cross_table(analysis.tables[name], analysis.factors), analysis.factors)
            yield Section(title, (Lead(lead), crossed, figure))


def _loss(analysis: Analysis) -> tuple[str, str, Figure]:
    table = analysis.tables["loss"]
    over = "participants" if table["n"].max() > 1 else "readings of one participant"
    within, bars = "", ""
    if table["mean_low"].notna().any():
        within, bars = f", with 95 % interval over {over}", "; bars are 95 % t-intervals"
    draw = partial(loss_figure, table, analysis.factors)
    figure = Figure("loss", draw, f"Loss of amplitude: means over {over}{bars}.", "loss")
    return "Loss of amplitude", f"Mean loss, 1 − measured / stated amplitude{within}.", figure


def _force(analysis: Analysis) -> tuple[str, str, Figure]:
    table, individuals = analysis.tables["force"], analysis.tables["force_participants"]
    stated = [] if analysis.study.force_n is None else [analysis.study.force_n]
    targets = sorted(set(individuals[TARGET].astype(float))) if TARGET in analysis.factors else stated
    values = table, individuals, analysis.factors, "force_mean_n"
    draw = partial(threshold_figure, *values, "Mean applied force (N)", targets=targets, from_zero=True)
    dashed = f"; dashed: {'the target' if len(targets) == 1 else 'targets'}" if targets else ""
    text = f"Mean applied force: {figure_text(table, 'faint dots are participants')}{dashed}."
    spread = " over participants ± standard deviation between them" if table["mean_low"].notna().any() else ""
    lead = f"Mean applied force{spread}, and time in the target band where it was measured."
    return "Applied force", lead, Figure("force", draw, text, "force")


def _terminal(analysis: Analysis) -> Iterator[TextTable]:
    for name, title in (("loss", "loss of amplitude"), ("force", "applied force")):
        if name in analysis.tables:
            table, spread = analysis.tables[name], ""
            if table["mean_low"].notna().any():
                over = "participants" if table["n"].max() > 1 else "readings"
                spread = f", 95 % interval over {over}" if name == "loss" else " ± SD between participants"
            cross = cross_table(table, analysis.factors)
            yield TextTable(cross, f"{title} (mean{spread})", across="condition")


KIND = ResultKind(_sections, _terminal, rows_of("loss", "force"))
