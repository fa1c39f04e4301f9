"""Rows as text for spreadsheets and other programs."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import astuple, fields
from pathlib import Path
from typing import Any

from ..errors import attempt
from .safe_text import cell_text

_QUOTED_SIGNS = '"\r\n'
"""The csv module leaves a carriage return unquoted in rows that end in a line feed, up to Python 3.12."""


def write_records(kind: type[Any], records: Iterable[Any], path: Path) -> None:
    """A row for each record of a dataclass, a column for each of its fields; a cell is empty where one is None.

    Raises `DeviceFailed` if the file cannot be written.
    """
    write_rows([field.name for field in fields(kind)], map(astuple, records), path)


def write_rows(head: Sequence[str], rows: Iterable[Sequence[Any]], path: Path) -> None:
    """A CSV in a folder that is made.

    Raises `DeviceFailed` if the file cannot be written.
    """
    with attempt(path, "cannot write", "a place to write to"):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(spreadsheet_text((head, *rows)))


def spreadsheet_text(rows: Iterable[Sequence[Any]], separator: str = ",") -> bytes:
    """Format rows in which a spreadsheet computes no text; otherwise as `delimited_text`."""
    return delimited_text(
        ([cell_text(cell) if isinstance(cell, str) else cell for cell in row] for row in rows), separator
    )


def delimited_text(rows: Iterable[Sequence[Any]], separator: str = ",") -> bytes:
    """Format rows with line feeds; a cell with a separator, quotation mark or line break is quoted, None is empty.

    >>> delimited_text([["a", "b\\r=1"], [None, 0.5]])
    b'a,"b\\r=1"\\n,0.5\\n'
    """
    special = re.compile(f"[{re.escape(separator + _QUOTED_SIGNS)}]")

    def quoted(value: Any) -> str:
        text = "" if value is None else str(value)
        return '"' + text.replace('"', '""') + '"' if special.search(text) else text

    lines = (separator.join(map(quoted, row)) or '""' for row in rows)  # an empty line would be no row
    return "".join(f"{line}\n" for line in lines).encode()
