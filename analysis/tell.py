"""The result in a terminal."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from tactometry.analysis.group import cross_table
from tactometry.analysis.number_text import LARGEST, number_text

if TYPE_CHECKING:
    import pandas as pd
    from rich.table import Table

    from tactometry.analysis.findings import Outcome
    from tactometry.analysis.pipeline import Analysis

NAMES = {
    "threshold": "threshold",
    "pse": "point of subjective equality",
    "jnd": "just noticeable difference",
    "setting": "setting by adjustment",
    "exponent": "exponent of magnitude estimates",
}


def tables(found: "Analysis") -> "Iterator[tuple[Table, Sequence[str]]]":
    """For each outcome its group table and what is to be said below it."""
    for outcome in found.outcomes:
        unit = f", {outcome.unit(found.unit)}" if outcome.unit(found.unit) else ""
        yield (
            outcome_table(outcome, f"{NAMES[outcome.dependent]}{unit} (mean, 95 % interval between participants, n)"),
            (*outcome.notes, *([outcome.heading()] if outcome.primary else []), *outcome.sentences),
        )
    for each in found.together:
        if each.fit is not None:
            cross = cross_table(each.conditions, each.fit.factors)
            title = "point of subjective equality" if each.task == "comparison" else "threshold"
            yield (
                text_table(cross, f"check, all participants at once: {title} (mean, 95 % interval)"),
                each.sentences(found.unit),
            )
    for form in found.forms:
        heading, lines = next(iter(form.sentences().items()))
        compared = [heading, *lines] if form.tests_effects else []
        yield (
            text_table(form.cross(), f"{form.form.title} (mean, 95 % interval between participants, n)"),
            [*form.notes, *compared],
        )
    for name in ("preference", "same_different"):
        if name in found.tables:
            yield text_table(found.tables[name], name.replace("_", " ")), ()
    if "loss" in found.tables:
        cross = cross_table(found.tables["loss"], found.trials.factors)
        yield text_table(cross, "loss of amplitude (mean, 95 % interval)"), ()
    if "force" in found.tables:
        yield text_table(cross_table(found.tables["force"], found.trials.factors), "applied force (mean ± SD)"), ()


def outcome_table(outcome: "Outcome", title: str) -> "Table":
    """The group table in the thesis's form."""
    return text_table(outcome.cross, title)


def text_table(cross: "pd.DataFrame", title: str) -> "Table":
    """Rows as they stand."""
    from rich.table import Table

    table = Table(title=title, title_justify="left", min_width=min(len(title), 78))
    for name in cross.columns:
        table.add_column(str(name), justify="right")
    for row in cross.itertuples(index=False, name=None):
        table.add_row(*map(_cell, row))
    return table


def _cell(value: object) -> str:
    """
    >>> _cell(240.0), _cell(12345.0), _cell(0.21349), _cell(7), _cell(None), _cell(float("nan"))
    ('240', '12345', '0.213', '7', '', '')
    """
    if value is None or (isinstance(value, float) and np.isnan(value)):
        return ""
    if isinstance(value, float):
        return str(int(value)) if value.is_integer() and abs(value) < LARGEST else number_text(value)
    return str(value)
