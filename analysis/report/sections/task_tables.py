"""Tables of tasks without a psychometric function."""

from collections.abc import Iterator
from functools import partial

import pandas as pd

from ...figures.psychophysics import share_figure
from ...result import Analysis
from ...tasks import preference
from ...tasks.kinds import RESULTS
from ..section import Content, Figure, Lead, ResultKind, Section, TextTable, details, grid, rows_of
from ..texts import caption

SHOWN = {task: results for task, results in RESULTS.items() if results.title or results.dependent}


def _views(analysis: Analysis) -> Iterator[tuple[str, pd.DataFrame]]:
    """Yield the readable table of each task, with notes only if there are any."""
    for task in (task for task in SHOWN if task in analysis.tables):
        shown = analysis.tables[SHOWN[task].compared or task]
        table = SHOWN[task].view(shown, analysis.trials, analysis.unit)
        is_noted = "note" in table.columns and (table["note"] != "").any()
        yield task, table if is_noted else table.drop(columns="note", errors="ignore")


def _sections(analysis: Analysis) -> Iterator[Section]:
    # Values of participants follow the section of their dependent variable.
    for task, view in _views(analysis):
        if SHOWN[task].dependent:
            yield Section("", (details(f"Participants: {task}", view, analysis.factors),))
    for task, view in _views(analysis):
        if SHOWN[task].title:
            blocks: list[Content] = [Lead(SHOWN[task].lead), grid(view, analysis.factors)]
            blocks += [_share_figure(analysis)] if task == preference.TASK else []
            yield Section(SHOWN[task].title, tuple(blocks))


def _share_figure(analysis: Analysis) -> Figure:
    shares = SHOWN[preference.TASK].view(analysis.tables[preference.SHARES], analysis.trials, analysis.unit)
    draw = partial(share_figure, shares, list(dict.fromkeys(shares["item"])))
    return Figure(preference.SHARES, draw, caption("preference", analysis.n_participants == 1), preference.SHARES)


def _terminal(analysis: Analysis) -> Iterator[TextTable]:
    for task, view in _views(analysis):
        if SHOWN[task].in_terminal:
            yield TextTable(view, SHOWN[task].in_terminal)


KIND = ResultKind(_sections, _terminal, rows_of(*SHOWN))
