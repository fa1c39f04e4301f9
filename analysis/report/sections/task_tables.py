"""Tables of tasks without a curve."""

from collections.abc import Iterator
from functools import partial

import pandas as pd

from ...figures.preference import share_figure
from ...result import Analysis
from ...tasks import preference
from ...tasks.kinds import RESULTS
from ..section import Content, Details, Figure, Lead, ResultKind, Section, TextTable, grid, rows_of

SHOWN = {task: results for task, results in RESULTS.items() if results.title or results.dependent}


def _views(analysis: Analysis) -> Iterator[tuple[str, pd.DataFrame]]:
    """Yield the table of each task for readers, with a column of notes only if there are any."""
    for task in (task for task in SHOWN if task in analysis.tables):
        shown = analysis.tables[SHOWN[task].compared or task]
        table = SHOWN[task].view(shown, analysis.trials, analysis.unit)
        is_noted = "note" in table.columns and (table["note"] != "").any()
        yield task, table if is_noted else table.drop(columns="note", errors="ignore")


def _sections(analysis: Analysis) -> Iterator[Section]:
    # The means of participants follow the sections of their dependent values.
    for task, view in _views(analysis):
        if SHOWN[task].dependent:
            title = f"Participants: {task} ({len(view)} rows)"
            yield Section("", (Details(title, (grid(view, analysis.factors),)),))
    for task, view in _views(analysis):
        if SHOWN[task].title:
            blocks: list[Content] = [Lead(SHOWN[task].lead), grid(view, analysis.factors)]
            blocks += [_share_figure(analysis)] if task == preference.TASK else []
            yield Section(SHOWN[task].title, tuple(blocks))


def _share_figure(analysis: Analysis) -> Figure:
    shares = SHOWN[preference.TASK].view(analysis.tables[preference.SHARES], analysis.trials, analysis.unit)
    together = "one participant" if analysis.trials.rows["participant"].nunique() == 1 else "all participants together"
    text = (
        f"How often each was preferred, of the pairs with it, {together}; bars are exact 95 % intervals, which count "
        "each answer as independent, dotted is chance."
    )
    items = list(dict.fromkeys(shares["item"]))
    return Figure(preference.SHARES, partial(share_figure, shares, items), text, preference.SHARES)


def _terminal(analysis: Analysis) -> Iterator[TextTable]:
    for task, view in _views(analysis):
        if SHOWN[task].in_terminal:
            yield TextTable(view, SHOWN[task].in_terminal)


KIND = ResultKind(_sections, _terminal, rows_of(*SHOWN))
