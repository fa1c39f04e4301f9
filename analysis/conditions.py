"""Tables by condition: a row for each combination of values of some columns."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import pandas as pd


def parts(table: pd.DataFrame, keys: Sequence[str]) -> Iterable[tuple[tuple[Any, ...], pd.DataFrame]]:
    """The rows of each combination of values, sorted by these; all of them without keys."""
    return table.groupby(list(keys), sort=True, observed=True) if keys else [((), table)]


def by_condition(
    table: pd.DataFrame, keys: Sequence[str], row_of: Callable[[pd.DataFrame], Mapping[str, object]]
) -> pd.DataFrame:
    """A row for each combination: its values, and what `row_of` makes of its rows. Empty of an empty table, which may
    lack the columns.

    >>> table = pd.DataFrame({"force_n": [3.0, 0.5, 3.0], "y": [1, 2, 3]})
    >>> by_condition(table, ["force_n"], lambda part: {"sum": part["y"].sum()}).values.tolist()
    [[0.5, 2.0], [3.0, 4.0]]
    """
    groups = parts(table, keys) if len(table) else ()
    return pd.DataFrame([dict(zip(keys, key, strict=True)) | dict(row_of(rows)) for key, rows in groups])
