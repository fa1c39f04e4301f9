"""Tables and sentences of a result for the terminal."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Final

from ..wording import in_words
from .kinds import KINDS
from .section import TextGrid, grid

if TYPE_CHECKING:
    from rich.table import Table

    from ..result import Analysis

BORDERS: Final = 3
"""Width of the borders of a column; the table itself adds one."""
MOST_FOLDED: Final = 60
"""Largest number of rows shown for a table with one cell per row."""


def tables(analysis: "Analysis", width: int) -> "Iterator[tuple[Table | None, Sequence[str]]]":
    """Yield each table (None if it is too wide) with the sentences below it."""
    factors = analysis.factors
    for table in (table for kind in KINDS for table in kind.terminal(analysis)):
        sentences = [in_words(sentence, factors) for sentence in table.sentences]
        n_keys = max(1, sum(name in factors for name in table.cross.columns))
        shown = text_table(grid(table.cross, factors), table.title, width, n_keys, table.across)
        where = analysis.tables_folder or "the tables of --report FILE.html"
        too_wide = f"{table.title}: too wide for {width} columns; see {where} (CSV)"
        yield shown, sentences if shown else [too_wide, *sentences]


def text_table(cells: TextGrid, title: str, width: int, n_keys: int, across: str) -> "Table | None":
    """Format a table without breaking words; return None if it is too large.

    A table that is too wide is shown with one row per cell: the first `n_keys` columns, the heading of the cell's
    column under `across`, and the cell.
    """
    from rich.table import Table

    widths = _widths(cells, width)
    if widths is None:
        cells = _one_cell_a_row(cells, n_keys, across)
        widths = _widths(cells, width) if len(cells.rows) <= MOST_FOLDED else None
    if widths is None:
        return None
    # rich wraps the title at the width of its table
    table = Table(title=title, title_justify="left", min_width=min(len(title), width - 2))
    for head, column in zip(cells.header, widths, strict=True):
        table.add_column(head, justify="right", width=column)
    for row in cells.rows:
        table.add_row(*row)
    return table


def _widths(cells: TextGrid, width: int) -> list[int] | None:
    """Return the width of each column, or None if a word does not fit."""
    columns = [[head, *(row[index] for row in cells.rows)] for index, head in enumerate(cells.header)]
    widths = [max(map(len, column)) for column in columns]
    least = [max(map(_longest_part, column)) for column in columns]
    room = width - 1 - BORDERS * len(columns)
    if sum(least) > room:
        return None
    while sum(widths) > room:
        widest = max(range(len(widths)), key=lambda index: widths[index] if widths[index] > least[index] else 0)
        widths[widest] -= 1
    return widths


def _longest_part(text: str) -> int:
    """Return the length of a value, or of the longest word of a text.

    >>> _longest_part("3.6 [2.8, 4.3] (n = 4)"), _longest_part("first of the pair")
    (22, 5)
    """
    return len(text) if any(map(str.isdigit, text)) else max(map(len, text.split()), default=0)


def _one_cell_a_row(cells: TextGrid, n_keys: int, across: str) -> TextGrid:
    """Return a table with one row for each cell that is not empty."""
    heads = cells.header[n_keys:]
    rows = [
        (*row[:n_keys], head, cell)
        for row in cells.rows
        for head, cell in zip(heads, row[n_keys:], strict=True)
        if cell
    ]
    return TextGrid((*cells.header[:n_keys], across, "value"), tuple(rows))
