"""Parquet files by pyarrow, an optional extra of 170 MB."""

from typing import Any

from tactometry.errors import library_needed


def arrow(where: str) -> Any:
    """Return pyarrow with its `parquet` module.

    Raises
    ------
    DeviceFailed
        If it is not installed; `where` begins the sentence.
    """
    with library_needed(f"{where}: found no pyarrow ({{error}}), expected it for Parquet files; {INSTALL}"):
        import pyarrow
        import pyarrow.parquet
    return pyarrow


INSTALL = "pip install 'tactometry[power]'"
