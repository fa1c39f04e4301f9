"""Text of rows, safe for spreadsheets, Markdown and file names."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import astuple, fields
from pathlib import Path
from typing import Any

from ..errors import attempt

LIST_OF_TABLES = "tables.txt"
"""File next to the tables of a report that lists them."""
_QUOTED_SIGNS = '"\r\n'
"""Up to Python 3.12 the csv module does not quote a carriage return in rows that end in a line feed."""


def write_records(kind: type[Any], records: Iterable[Any], path: Path) -> None:
    """Write records of a dataclass as CSV, a column for each field."""
    write_rows([field.name for field in fields(kind)], map(astuple, records), path)


def write_rows(head: Sequence[str], rows: Iterable[Sequence[Any]], path: Path) -> None:
    """Write a CSV file, and create its folder."""
    with attempt(path, "cannot write", "a writable place"):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(spreadsheet_text((head, *rows)))


def spreadsheet_text(rows: Iterable[Sequence[Any]], separator: str = ",") -> bytes:
    """Format rows in which a spreadsheet does not compute any text."""
    return delimited_text(
        ([cell_text(cell) if isinstance(cell, str) else cell for cell in row] for row in rows), separator
    )


def delimited_text(rows: Iterable[Sequence[Any]], separator: str = ",") -> bytes:
    """Format rows with line feeds, quoted where needed. None is empty.

    >>> delimited_text([["a", "b\\r=1"], [None, 0.5]])
    b'a,"b\\r=1"\\n,0.5\\n'
    """
    special = re.compile(f"[{re.escape(separator + _QUOTED_SIGNS)}]")

    def quoted(value: Any) -> str:
        text = "" if value is None else str(value)
        return '"' + text.replace('"', '""') + '"' if special.search(text) else text

    lines = (separator.join(map(quoted, row)) or '""' for row in rows)  # a reader would skip an empty line
    return "".join(f"{line}\n" for line in lines).encode()


FORMULA = ("=", "+", "-", "@", "\t", "\r", "\n", "\uff1d", "\uff0b", "\uff0d", "\uff20")
"""Characters with which a text begins that a spreadsheet computes (OWASP, "CSV injection"). The last four are
full-width."""
BYTE_ORDER_MARK = "\ufeff"
_MARKUP = re.compile(r"[\\<\[]")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")


def cell_text(text: str) -> str:
    """Escape a text that a spreadsheet would compute.

    A leading byte-order mark, which programs skip, is removed.

    >>> cell_text("=1+1"), cell_text("\\ufeff=1+1"), cell_text("-0.5"), cell_text("P01")
    ("'=1+1", "'=1+1", '-0.5', 'P01')
    """
    text = text.lstrip(BYTE_ORDER_MARK)
    return f"'{text}" if text.startswith(FORMULA) and not _NUMBER.fullmatch(text) else text


def markdown_text(text: str) -> str:
    r"""Escape characters that begin HTML or a link in Markdown.

    >>> print(markdown_text("<script> [a](b)"))
    \<script> \[a](b)
    """
    return _MARKUP.sub(r"\\\g<0>", text.lstrip(BYTE_ORDER_MARK))


def file_text(text: str) -> str:
    """Replace characters that are unsafe in a file name by their code.

    >>> file_text("force_n"), file_text("x/../y")
    ('force_n', 'x%2F..%2Fy')
    """
    return "".join(sign if sign.isalnum() or sign in "_-." else f"%{ord(sign):02X}" for sign in text)
