"""TOML files from disk or a package, with one error message per file."""

import re
import tomllib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from importlib.resources import files
from pathlib import Path
from typing import Any, Final, TypeVar

from ..arguments.require import one_of
from ..errors import InvalidFile, TactometryError, reworded
from ..files.durable import read_file
from ..files.json_file import levels

LARGEST_FILE: Final = 1_000_000
"""Largest size of a file, in bytes, which is about 25 000 lines."""
LONGEST_LIST, DEEPEST = 10_000, 30


def read_table(path: Path, what: str) -> dict[str, Any]:
    """Return the table of a file. `what` describes the expected file."""
    return table_of(read_file(path, what, LARGEST_FILE), str(path), what)


def table_of(content: bytes, where: str, what: str) -> dict[str, Any]:
    """Parse the bytes of a TOML file. `where` begins each error message.

    Raises `InvalidFile` if the bytes are not UTF-8 or TOML, or exceed `LARGEST_FILE`, `LONGEST_LIST` or `DEEPEST`.

    >>> table_of(b"accuracy = 0.01", "s.toml", "a scene file")
    {'accuracy': 0.01}
    """
    if len(content) > LARGEST_FILE:
        raise InvalidFile(f"{where}: found {len(content)} bytes, expected {what} of at most {LARGEST_FILE}")
    try:
        text = content.decode("utf-8-sig")
        table = tomllib.loads(text)
    except UnicodeDecodeError as damage:
        raise InvalidFile(
            f"{where}, byte {damage.start}: found a byte that is not UTF-8, expected {what} in UTF-8"
        ) from None
    except (ValueError, RecursionError) as damage:
        twice = _declared_twice(text, str(damage))
        raise InvalidFile(f"{where}: found {twice or f'no valid TOML ({damage}), expected {what}'}") from None
    _refuse_vast(table, where, what)
    return table


def _declared_twice(text: str, damage: str) -> str:
    """Return an error with both lines of a table that is declared twice."""
    named = re.match(r"Cannot declare \((.*)\) twice", damage)
    if named is None:
        return ""
    name = ".".join(re.findall(r"'([^']*)'", named[1]))
    lines = [
        f"{number}" for number, line in enumerate(text.splitlines(), 1) if line.partition("#")[0].strip() == f"[{name}]"
    ]
    if len(lines) < 2:
        return ""
    return f"[{name}] in lines {' and '.join(lines)}, expected one table; join their keys"


def _refuse_vast(table: dict[str, Any], where: str, what: str) -> None:
    for depth, level in enumerate(levels(table)):
        longest = max((len(each) for each in level if isinstance(each, list)), default=0)
        if longest > LONGEST_LIST:
            raise InvalidFile(f"{where}: found a list of {longest} items, expected {what} with at most {LONGEST_LIST}")
        if depth == DEEPEST:
            raise InvalidFile(f"{where}: found tables more than {DEEPEST} deep, expected {what}")


@contextmanager
def errors_in(where: str | Path) -> Iterator[None]:
    """Raise `InvalidFile`, with `where`, for errors in a file's content.

    >>> with errors_in("s.toml"):
    ...     raise InvalidFile("accuracy: found 2, expected at most 1")
    Traceback (most recent call last):
    tactometry.errors.InvalidFile: s.toml, accuracy: found 2, expected at most 1
    """
    try:
        yield
    except TactometryError as wrong:
        raise reworded(wrong, InvalidFile, lambda words: f"{where}, {words.removeprefix(': ')}") from None


T = TypeVar("T")
SUFFIX: Final = ".toml"


def shipped_in(package: str) -> tuple[str, ...]:
    """Return the names of the TOML files of a package.

    >>> "attrakdiff" in shipped_in("tactometry.questionnaires")
    True
    """
    names = (entry.name for entry in files(package).iterdir())
    return tuple(sorted(name.removesuffix(SUFFIX) for name in names if name.endswith(SUFFIX)))


def load_shipped(package: str, name: str, what: str, parse: Callable[[bytes, str], T]) -> T:
    """Load a TOML file of a package. `parse` receives bytes and error prefix."""
    one_of(what, name, shipped_in(package))
    return parse((files(package) / f"{name}{SUFFIX}").read_bytes(), f"{what} {name}")


def shipped_table(package: str, name: str) -> dict[str, Any]:
    """Return the table of a TOML file of a package, which no user writes.

    >>> shipped_table("tactometry.questionnaires", "attrakdiff")["name"]
    'attrakdiff'
    """
    file = f"{name}{SUFFIX}"
    return table_of((files(package) / file).read_bytes(), file, "a table")


def merge(table: Mapping[str, Any], change: Mapping[str, Any]) -> dict[str, Any]:
    """Return a table with some keys changed, including keys of inner tables.

    >>> merge({"a": 1, "b": {"c": 2, "d": 3}}, {"b": {"c": 4}})
    {'a': 1, 'b': {'c': 4, 'd': 3}}
    """
    changed = dict(table)
    for key, value in change.items():
        are_tables = isinstance(value, Mapping) and isinstance(table.get(key), Mapping)
        changed[key] = merge(table[key], value) if are_tables else value
    return changed
