"""Rows as a CSV, for people and spreadsheets: what is computed, which can be made again."""

import csv
from collections.abc import Iterable, Sequence
from dataclasses import astuple, fields
from pathlib import Path
from typing import Any

from ..errors import attempt


def write_records(kind: type[Any], records: Iterable[Any], path: Path) -> None:
    """A row for each record of a dataclass, a column for each of its fields; a cell is empty where one is None.

    Raises
    ------
    DeviceFailed
        If the file cannot be written.
    """
    write_rows([field.name for field in fields(kind)], map(astuple, records), path)


def write_rows(head: Sequence[str], rows: Iterable[Sequence[Any]], path: Path) -> None:
    """A CSV in a folder that is made.

    Raises
    ------
    DeviceFailed
        If the file cannot be written.
    """
    with attempt(path, "cannot write", "a place to write to"):
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerows((head, *rows))
