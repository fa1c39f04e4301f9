"""What a report is made of: kinds of results, which tell themselves in sections of blocks; tables as text, and as plain
rows for JSON."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar

import pandas as pd

from ..figures.style import Drawing
from ..result import Analysis
from ..wording import cell_text, header_of, plain_text


@dataclass(frozen=True)
class TextGrid:
    """A table as text for people, heads in words."""

    kind: ClassVar = "table"
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    @cached_property  # the page asks for it in every cell
    def is_text(self) -> tuple[bool, ...]:
        """For each column whether it holds words: the first does, and each with a cell without a digit.

        >>> TextGrid(("participant", "mean", "note"), (("P01", "1.2", "no pairs"), ("P02", "", ""))).is_text
        (True, False, True)
        """
        cells = zip(*self.rows, strict=True) if self.rows else ((),) * len(self.header)
        worded = [any(cell and not any(map(str.isdigit, cell)) for cell in column) for column in cells]
        return (True, *worded[1:])


def grid(table: pd.DataFrame, factors: Sequence[str]) -> TextGrid:
    """Values of factors as they were stated, other numbers with three significant digits.

    >>> grid(pd.DataFrame({"force_n": [0.5], "mean": [0.5]}), ["force_n"])
    TextGrid(header=('Force (N)', 'mean'), rows=(('0.5', '0.500'),))
    """
    columns = [[_text(value, is_level=name in factors) for value in table[name]] for name in table.columns]
    heads = tuple(header_of(str(name), factors) for name in table.columns)
    return TextGrid(heads, tuple(zip(*columns, strict=True)) if columns else ())


def _text(value: Any, *, is_level: bool) -> str:
    return plain_text(value) if is_level and pd.notna(value) else cell_text(value)


@dataclass(frozen=True)
class Lead:
    """A paragraph before what it explains."""

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
    """Sentences by their headings, of which the first `n_open` are unfolded."""

    kind: ClassVar = "folded"
    by_heading: Mapping[str, Sequence[str]]
    n_open: int


Draw = Callable[[], Drawing]


@dataclass(frozen=True)
class Figure:
    """A figure with its file name, caption, and the table of numbers: of them those rows that `of` holds.

    It is drawn when it is written, because all figures of a report would take 30 MiB for each participant.
    """

    kind: ClassVar = "figure"
    name: str
    draw: Draw
    caption: str
    table: str
    of: tuple[str, str] | None = None

    def rows(self, table: pd.DataFrame) -> pd.DataFrame:
        """The rows of its table that it draws."""
        return table if self.of is None else table[table[self.of[0]] == self.of[1]]


@dataclass(frozen=True)
class Details:
    """Blocks that a reader unfolds."""

    kind: ClassVar = "details"
    title: str
    blocks: "tuple[Content, ...]"
    is_open: bool = False


Content = Lead | Heading | TextGrid | Sentences | Folded | Figure | Details
Blocks = Iterator[Content]


@dataclass(frozen=True)
class Section:
    """A part of the page; without a title it goes on with the one before."""

    title: str
    blocks: tuple[Content, ...]

    def figures(self) -> list[Figure]:
        """Those in its blocks and in what these unfold."""
        folded = [inner for block in self.blocks if isinstance(block, Details) for inner in block.blocks]
        return [block for block in (*self.blocks, *folded) if isinstance(block, Figure)]


@dataclass(frozen=True)
class TextTable:
    """A table of the terminal, with what is said below it; `across` names what its heads are."""

    cross: pd.DataFrame
    title: str
    sentences: Sequence[str] = ()
    across: str = "quantity"


@dataclass(frozen=True)
class ResultKind:
    """A kind of result: its sections of the page, its tables of the terminal, and its values in JSON (tables as they
    are), where an analysis holds it. Sections alone draw figures."""

    sections: Callable[[Analysis], Iterable[Section]] = field(default=lambda analysis: ())
    terminal: Callable[[Analysis], Iterable[TextTable]] = field(default=lambda analysis: ())
    values: Callable[[Analysis], Iterable[tuple[str, object]]] = field(default=lambda analysis: ())


def rows_of(*names: str) -> Callable[[Analysis], Iterable[tuple[str, object]]]:
    """These tables as values in JSON, by their names; one that there is not has no rows."""
    return lambda analysis: [(name, analysis.table(name)) for name in names]
