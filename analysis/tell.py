"""The result in a terminal."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from rich.table import Table

    from tactometry.analysis.pipeline import Analysis, Outcome

NAMES = {"threshold": "threshold", "pse": "point of subjective equality", "jnd": "just noticeable difference"}


def tables(found: "Analysis") -> "Iterator[tuple[Table, Sequence[str]]]":
    """For each outcome its group table and what is to be said below it."""
    for outcome in found.outcomes:
        unit = f", {found.unit}" if found.unit else ""
        yield (
            outcome_table(outcome, f"{NAMES[outcome.dependent]}{unit} (mean, 95 % interval, n)"),
            (
                *outcome.notes,
                *outcome.sentences,
            ),
        )


def outcome_table(outcome: "Outcome", title: str) -> "Table":
    """The group table in the thesis's form."""
    from rich.table import Table

    table = Table(title=title, title_justify="left", min_width=min(len(title), 78))
    for name in outcome.cross.columns:
        table.add_column(str(name), justify="right")
    for row in outcome.cross.itertuples(index=False, name=None):
        table.add_row(*(f"{v:g}" if isinstance(v, int | float | np.number) else str(v) for v in row))
    return table
