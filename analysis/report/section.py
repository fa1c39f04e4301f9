"""Parts of a report: sections of blocks, and terminal tables."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar

import pandas as pd

from ..figures.style import Drawing
from ..result import Analysis
from ..wording import cell_text, header_of, plain_text


@dataclass(frozen=True)
class TextGrid:
    """Table of text cells with readable headings."""

    kind: ClassVar = "table"
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    @cached_property  # cached, as every cell of the page uses it
    def is_text(self) -> tuple[bool, ...]:
        """True for the first column and columns with a cell without digits.

        >>> TextGrid(("participant", "mean", "note"), (("P01", "1.2", "no pairs"), ("P02", "", ""))).is_text
        (True, False, True)
        """
        cells = zip(*self.rows, strict=True) if self.rows else ((),) * len(self.header)
        worded = [any(cell and not any(map(str.isdigit, cell)) for cell in column) for column in cells]
        return (True, *worded[1:])


def grid(table: pd.DataFrame, factors: Sequence[str]) -> TextGrid:
    """Format a table: levels as stated, numbers with three digits.

    >>> grid(pd.DataFrame({"force_n": [0.5], "mean": [0.5]}), ["force_n"])
    TextGrid(header=('Force (N)', 'mean'), rows=(('0.5', '0.500'),))
    """
    columns = []
    for name in table.columns:
        known = table[name].notna() if name in factors else pd.Series(False, table.index)
        values = zip(table[name], known, strict=True)
        columns.append([plain_text(value) if is_level else cell_text(value) for value, is_level in values])
    heads = tuple(header_of(str(name), factors) for name in table.columns)
    return TextGrid(heads, tuple(zip(*columns, strict=True)) if columns else ())


@dataclass(frozen=True)
class Lead:
    """An introductory paragraph."""

    kind: ClassVar = "lead"
    text: str


@dataclass(frozen=True)
class Heading:
    """A heading within a section."""

    kind: ClassVar = "heading"
    text: str


@dataclass(frozen=True)
class Sentences:
    kind: ClassVar = "sentences"
    lines: Sequence[str]


@dataclass(frozen=True)
class Folded:
    """Sentences by heading, folded except for the first `n_open`."""

    kind: ClassVar = "folded"
    by_heading: Mapping[str, Sequence[str]]
    n_open: int


Draw = Callable[[], Drawing]


@dataclass(frozen=True)
class Figure:
    """A figure with its file name, caption and table.

    `of` (column, value) selects rows of the table. The figure is drawn only when written, as all figures of a report
    take 30 MiB per participant.
    """

    kind: ClassVar = "figure"
    name: str
    draw: Draw
    caption: str
    table: str
    of: tuple[str, str] | None = None

    def rows(self, table: pd.DataFrame) -> pd.DataFrame:
        return table if self.of is None else table[table[self.of[0]] == self.of[1]]


@dataclass(frozen=True)
class Details:
    """Blocks under a title that can be unfolded."""

    kind: ClassVar = "details"
    title: str
    blocks: "tuple[Content, ...]"
    is_open: bool = False


def details(title: str, table: pd.DataFrame, factors: Sequence[str]) -> Details:
    """Return a folded table whose title contains its number of rows."""
    return Details(f"{title} ({len(table)} rows)", (grid(table, factors),))


Content = Lead | Heading | TextGrid | Sentences | Folded | Figure | Details
Blocks = Iterator[Content]


@dataclass(frozen=True)
class Section:
    """Part of the page; without a title it continues the previous section."""

    title: str
    blocks: tuple[Content, ...]

    def figures(self) -> list[Figure]:
        """Return the figures of the section, including folded ones."""
        folded = [inner for block in self.blocks if isinstance(block, Details) for inner in block.blocks]
        return [block for block in (*self.blocks, *folded) if isinstance(block, Figure)]


@dataclass(frozen=True)
class TextTable:
    """Terminal table with sentences below it.

    `across` is the common name of the column headings.
    """

    cross: pd.DataFrame
    title: str
    sentences: Sequence[str] = ()
    across: str = "quantity"


@dataclass(frozen=True)
class ResultKind:
    """Presentation of one kind of result on page, in terminal and as JSON."""

    sections: Callable[[Analysis], Iterable[Section]] = field(default=lambda analysis: ())
    terminal: Callable[[Analysis], Iterable[TextTable]] = field(default=lambda analysis: ())
    values: Callable[[Analysis], Iterable[tuple[str, object]]] = field(default=lambda analysis: ())


def rows_of(*names: str) -> Callable[[Analysis], Iterable[tuple[str, object]]]:
    """Return a function that yields the named tables as JSON values."""
    return lambda analysis: [(name, analysis.table(name)) for name in names]
