"""Measurements by condition: loss of amplitude, and applied force."""

from collections.abc import Iterator
from functools import partial

import pandas as pd

from ...figures.psychophysics import loss_figure, threshold_figure
from ...outcomes.findings import FORCE as TARGET
from ...result import Analysis
from ...wording import cross_table
from ..captions import figure_text
from ..section import Figure, Lead, ResultKind, Section, TextTable, grid, rows_of


def _sections(analysis: Analysis) -> Iterator[Section]:
    for name, describe in (("loss", _loss), ("force", _force)):
        if name in analysis.tables:
            title, lead, figure = describe(analysis, analysis.tables[name])
            crossed = grid(cross_table(analysis.tables[name], analysis.factors), analysis.factors)
            yield Section(title, (Lead(lead), crossed, figure))


def _loss(analysis: Analysis, table: pd.DataFrame) -> tuple[str, str, Figure]:
    has_interval = bool(table["mean_low"].notna().any())
    over = "participants" if table["n"].max() > 1 else "readings of one participant"
    within = f", with 95 % interval over {over}" if has_interval else ""
    bars = "; bars are 95 % t-intervals" if has_interval else ""
    draw = partial(loss_figure, table, analysis.factors)
    figure = Figure("loss", draw, f"Loss of amplitude: means over {over}{bars}.", table="loss")
    return "Loss of amplitude", f"Mean loss, 1 − measured / stated amplitude{within}.", figure


def _force(analysis: Analysis, table: pd.DataFrame) -> tuple[str, str, Figure]:
    spread = " over participants ± standard deviation between them" if table["mean_low"].notna().any() else ""
    lead = f"Mean applied force{spread}, and time in the target band where it was measured."
    return "Applied force", lead, _force_figure(analysis)


def _force_figure(analysis: Analysis) -> Figure:
    table, individuals = analysis.tables["force"], analysis.tables["force_participants"]
    stated = [] if analysis.study.force_n is None else [analysis.study.force_n]
    targets = sorted(set(individuals[TARGET].astype(float))) if TARGET in analysis.factors else stated
    values = table, individuals, analysis.factors, "force_mean_n"
    draw = partial(threshold_figure, *values, "Mean applied force (N)", targets=targets, from_zero=True)
    dashed = f"; dashed: {'the target' if len(targets) == 1 else 'targets'}" if targets else ""
    text = f"Mean applied force: {figure_text(table, 'faint dots are participants')}{dashed}."
    return Figure("force", draw, text, "force")


def _terminal(analysis: Analysis) -> Iterator[TextTable]:
    for name, title in (("loss", _loss_title), ("force", _force_title)):
        if name in analysis.tables:
            table = analysis.tables[name]
            yield TextTable(cross_table(table, analysis.factors), title(table), across="condition")


def _loss_title(table: pd.DataFrame) -> str:
    over = "participants" if table["n"].max() > 1 else "readings"
    interval = f", 95 % interval over {over}" if table["mean_low"].notna().any() else ""
    return f"loss of amplitude (mean{interval})"


def _force_title(table: pd.DataFrame) -> str:
    spread = " ± SD between participants" if table["mean_low"].notna().any() else ""
    return f"applied force (mean{spread})"


KIND = ResultKind(_sections, _terminal, rows_of("loss", "force"))
