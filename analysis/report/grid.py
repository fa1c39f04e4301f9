"""A table as text for people, heads in words, and as plain rows for JSON."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
import pandas as pd

from ..wording import cell_text, header_of, plain_text


@dataclass(frozen=True)
class TextGrid:
    """A table as text."""

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


def plain_rows(table: pd.DataFrame) -> list[dict[str, object]]:
    """Rows as plain values: None for what is missing."""
    return [{str(name): _plain(value) for name, value in row.items()} for row in table.to_dict("records")]


def _plain(value: object) -> object:
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not np.isfinite(value) else value
