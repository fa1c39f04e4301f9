"""Files in TOML as tables: every way in which one cannot be read is one sentence that names it."""

import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tactometry.errors import InvalidFile, TactometryError


def read_table(path: Path, what: str) -> dict[str, Any]:
    """The table of a file; `what` says in an error what was expected.

    Raises
    ------
    InvalidFile
        If the file cannot be read, or as `table_of`.
    """
    try:
        content = path.read_bytes()
    except OSError as failure:
        raise InvalidFile(f"{path}: cannot be read ({failure.strerror}), expected {what}") from None
    return table_of(content, str(path), what)


def table_of(content: bytes, where: str, what: str) -> dict[str, Any]:
    """The table of the bytes of a file; `where` opens every sentence.

    Raises
    ------
    InvalidFile
        If the bytes are no UTF-8 or no TOML.

    Examples
    --------
    >>> table_of(b"accuracy = 0.01", "s.toml", "a scene file")
    {'accuracy': 0.01}
    """
    try:
        return tomllib.loads(content.decode("utf-8"))
    except UnicodeDecodeError as damage:
        raise InvalidFile(
            f"{where}, byte {damage.start}: found a byte that is not UTF-8, expected {what} in UTF-8"
        ) from None
    except (ValueError, RecursionError) as damage:
        raise InvalidFile(f"{where}: found no valid TOML ({damage}), expected {what}") from None


@contextmanager
def located(where: str | Path) -> Iterator[None]:
    """What is wrong with the content of a file, with its place: `where` before the key path.

    Raises
    ------
    InvalidFile
        If the body raises an error that a person can mend.

    Examples
    --------
    >>> with located("s.toml"):
    ...     raise InvalidFile("accuracy: found 2, expected at most 1")
    Traceback (most recent call last):
    tactometry.errors.InvalidFile: s.toml, accuracy: found 2, expected at most 1
    """
    try:
        yield
    except TactometryError as wrong:
        raise InvalidFile(f"{where}, {str(wrong).removeprefix(': ')}") from None
