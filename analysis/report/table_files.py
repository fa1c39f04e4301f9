"""Tables of an analysis as CSV files that a spreadsheet opens and computes nothing of."""

from collections.abc import Mapping
from pathlib import Path

import pandas as pd

from tactometry.files.safe_text import cell_text, file_text


def write_tables(tables: Mapping[str, pd.DataFrame], folder: Path) -> None:
    """Each table as NAME.csv in the folder.

    Raises
    ------
    OSError
        If the disk is full or fails.
    """
    for name, table in tables.items():
        (folder / f"{file_text(name)}.csv").write_text(csv_text(table), encoding="utf-8")


def csv_text(table: pd.DataFrame) -> str:
    """A table as CSV: text that begins like a formula has an apostrophe before it, numbers stay as they are.

    >>> csv_text(pd.DataFrame({"@pattern": ["=1+1", "P0"], "threshold": [-1.5, 2.0]}))
    "'@pattern,threshold\\n'=1+1,-1.5\\nP0,2.0\\n"
    """
    safe = table.map(lambda value: cell_text(value) if isinstance(value, str) else value)
    safe.columns = [cell_text(str(name)) for name in table.columns]
    return str(safe.to_csv(index=False, lineterminator="\n"))
