"""Measurements by condition: loss of amplitude, and applied force."""

from collections.abc import Iterator
from functools import partial

import pandas as pd

from ...figures.psychophysics import loss_figure, threshold_figure
from ...outcomes.findings import FORCE as TARGET
from ...result import Analysis
from ...wording import cross_table
from ..section import Figure, Lead, ResultKind, Section, TextTable, grid, rows_of
from ..texts import caption, facts_of


def _sections(analysis: Analysis) -> Iterator[Section]:
    for name, title, parts in (("loss", "Loss of amplitude", _loss), ("force", "Applied force", _force)):
        if name in analysis.tables:
            lead, figure = parts(analysis)
            crossed = grid(cross_table(analysis.tables[name], analysis.factors), analysis.factors)
            yield Section(title, (Lead(lead), crossed, figure))


def _has_interval(table: pd.DataFrame) -> bool:
    return bool(table["mean_low"].notna().any())


def _loss(analysis: Analysis) -> tuple[str, Figure]:
    table = analysis.tables["loss"]
    facts = "participants" if table["n"].max() > 1 else "readings of one participant", _has_interval(table)
    draw = partial(loss_figure, table, analysis.factors)
    return caption("loss_lead", *facts), Figure("loss", draw, caption("loss", *facts), "loss")


def _force(analysis: Analysis) -> tuple[str, Figure]:
    table, individuals = analysis.tables["force"], analysis.tables["force_participants"]
    stated = [] if analysis.study.force_n is None else [analysis.study.force_n]
    targets = sorted(set(individuals[TARGET].astype(float))) if TARGET in analysis.factors else stated
    values = table, individuals, analysis.factors, "force_mean_n"
    draw = partial(threshold_figure, *values, "Mean applied force (N)", targets=targets, from_zero=True)
    text = caption("force", facts_of(table), targets)
    return caption("force_lead", _has_interval(table)), Figure("force", draw, text, "force")


def _terminal(analysis: Analysis) -> Iterator[TextTable]:
    for name, title in (("loss", "loss of amplitude"), ("force", "applied force")):
        if name in analysis.tables:
            table, spread = analysis.tables[name], ""
            if _has_interval(table):
                over = "participants" if table["n"].max() > 1 else "readings"
                spread = f", 95 % interval over {over}" if name == "loss" else " ± SD between participants"
            yield TextTable(cross_table(table, analysis.factors), f"{title} (mean{spread})", across="condition")


KIND = ResultKind(_sections, _terminal, rows_of("loss", "force"))
