"""What a report is made of: kinds of results, which tell themselves in sections of blocks."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import pandas as pd

from ..figures.style import Drawing
from ..result import Analysis
from .grid import TextGrid, plain_rows


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
class FoldedSentences:
    """Sentences by their headings, of which the first `n_open` are unfolded."""

    kind: ClassVar = "folded"
    by_heading: Mapping[str, Sequence[str]]
    n_open: int


@dataclass(frozen=True)
class Figure:
    """A drawing with its file name, caption, and the table of numbers: of them those rows that `of` holds."""

    kind: ClassVar = "figure"
    name: str
    drawing: Drawing
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


Content = Lead | Heading | TextGrid | Sentences | FoldedSentences | Figure | Details


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
    """A table of the terminal, with what is said below it."""

    cross: pd.DataFrame
    title: str
    sentences: Sequence[str] = ()


@dataclass(frozen=True)
class ResultKind:
    """A kind of result: its sections of the page, its tables of the terminal, and its values in JSON, where an analysis
    holds it. Sections alone draw figures."""

    sections: Callable[[Analysis], Iterable[Section]] = field(default=lambda analysis: ())
    terminal: Callable[[Analysis], Iterable[TextTable]] = field(default=lambda analysis: ())
    values: Callable[[Analysis], Iterable[tuple[str, object]]] = field(default=lambda analysis: ())


def rows_of(*names: str) -> Callable[[Analysis], Iterable[tuple[str, object]]]:
    """The rows of these tables as values in JSON, by the names of the tables; of a table that there is not none."""
    return lambda analysis: [(name, plain_rows(analysis.table(name))) for name in names]
