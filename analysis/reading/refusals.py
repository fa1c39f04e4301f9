"""What is said of a table that cannot be read: where it is, what was found, what was expected."""

from typing import Any

import pandas as pd

from tactometry.errors import InvalidFile, nearest
from tactometry.trials.row_rules import rows_text


def place_of(rows: pd.DataFrame) -> str:
    """Where rows of a table of trials stand: the first of them, and how many more there are."""
    numbers = rows["row"].tolist()
    return f"{rows['source'].iloc[0]}{rows_text(numbers[0], numbers[1:], len(numbers))}"


def bad_cell(row: "pd.Series[Any]", column: str, found: str, expected: str) -> InvalidFile:
    """Of a row of a table of trials, which says where it stands in which file."""
    return InvalidFile(f"{row['source']}, row {row['row']}, column {column!r}: found {found}, expected {expected}")


def no_column(name: str, table: pd.DataFrame) -> str:
    """
    >>> no_column("levl", pd.DataFrame({"level": [1.0]}))
    "found no column 'levl'; did you mean 'level'?"
    """
    return f"found no column {name!r}{nearest(name, [str(column) for column in table.columns])}"
