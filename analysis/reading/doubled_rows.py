"""Trials that stand twice in a table: rows that were copied, or counted anew."""

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

KEY = (
    *("participant", "study", "session", "block", "task", "procedure"),
    *("trial", "attempt", "item", "item_b", "track", "catch", "level"),
)
"""What no two rows share, with the factors: other programs count trials anew in each condition, or at each level. Of
them, those columns that are there."""


def doubled(rows: pd.DataFrame, factors: Sequence[str] = ()) -> list[str]:
    """A warning with the number of rows that repeat a trial before them, and the first. None without numbers of trials.

    >>> row = {"participant": "P1", "trial": 1.0, "response": "1", "source": "a.csv", "row": 2}
    >>> doubled(pd.DataFrame([row, row | {"trial": 2.0, "row": 3}, row | {"response": "0", "row": 4}]))[0][:66]
    '1 row repeats a trial that stands before it (the first: a.csv, row'
    """
    if "trial" not in rows.columns:
        return []
    numbered = rows[rows["trial"].notna()]
    again = numbered[numbered.duplicated([name for name in (*KEY, *factors) if name in rows.columns])]
    if again.empty:
        return []
    alike = int(numbered.duplicated([name for name in rows.columns if name not in ("source", "row")]).sum())
    first = again.iloc[0]
    place = f"{Path(str(first['source'])).name}, row {first['row']}"
    said = (
        "1 row repeats a trial that stands before it"
        if len(again) == 1
        else f"{len(again)} rows repeat trials that stand before them"
    )
    return [
        f"{said} (the first: {place}; {alike} of {len(again)} alike in every cell): "
        "each counts as a trial of its own; take copies out, or number trials through the session"
    ]
