"""The result in a terminal."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from ..wording import in_words
from .kinds import KINDS
from .section import grid

if TYPE_CHECKING:
    import pandas as pd
    from rich.table import Table

    from ..result import Analysis


def tables(analysis: "Analysis") -> "Iterator[tuple[Table, Sequence[str]]]":
    """Each table with what is to be said below it; factors in words."""
    factors = analysis.factors
    for table in (table for kind in KINDS for table in kind.terminal(analysis)):
        sentences = [in_words(sentence, factors) for sentence in table.sentences]
        yield text_table(table.cross, table.title, factors), sentences


def text_table(cross: "pd.DataFrame", title: str, factors: Sequence[str]) -> "Table":
    """Rows as they stand, under heads in words."""
    from rich.table import Table

    # rich folds a title at the width of its table.
    table = Table(title=title, title_justify="left", min_width=min(len(title), 78))
    cells = grid(cross, factors)
    for head in cells.header:
        table.add_column(head, justify="right", overflow="fold")
    for row in cells.rows:
        table.add_row(*row)
    return table
