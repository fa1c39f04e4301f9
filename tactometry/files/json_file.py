"""Reading of JSON within limits of size and depth."""

import json
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Final

from ..errors import InvalidFile
from ..provenance import versions
from .durable import make_folder, read_file, write_atomically

LARGEST_OBJECT: Final = 2**24
"""Largest size of a file with one object, bytes (unverified default)."""
DEEPEST: Final = 100
"""Largest nesting depth of lists and objects."""
_SPACE: Final = re.compile(r"\s*")
_VERBATIM: Final = json.JSONDecoder(parse_float=str, parse_int=str, parse_constant=str)


def json_value(text: str | bytes) -> Any:
    """Parse JSON.

    Raises `ValueError` if the text is not JSON, contains half of a character, or is nested deeper than `DEEPEST`.

    >>> json_value('{"a": [1]}')
    {'a': [1]}
    """
    try:
        value = json.loads(text)
    except RecursionError:
        raise _too_deep() from None
    return _checked(value)


def json_object(path: Path, what: str) -> dict[str, Any]:
    """Read a file with one JSON object. `what` describes the file.

    Raises `InvalidFile` if the file cannot be read, is larger than `LARGEST_OBJECT` bytes, or is not a JSON object.
    """
    content = read_file(path, what, LARGEST_OBJECT)
    try:
        value = json_value(content)
    except ValueError as error:
        raise InvalidFile(f"{path}: found no JSON ({error}), expected {what}") from None
    if not isinstance(value, dict):
        raise InvalidFile(f"{path}: found no JSON object, expected {what}")
    return value


def json_items(text: str) -> Iterator[Any]:
    """Parse items of consecutive JSON lists one by one, numbers as text.

    Raises `ValueError` if the text is not a JSON list, or if an item contains half of a character or is nested too
    deeply.

    >>> list(json_items("[1, [0.10]] [null]"))
    ['1', ['0.10'], None]
    """
    place = _skip(text, 0)
    while place < len(text):
        if text[place] != "[":
            raise json.JSONDecodeError("Expecting a list", text, place)
        place = _skip(text, place + 1)
        is_over = text[place : place + 1] == "]"
        while not is_over:
            item, place = _item(text, place)
            yield item
            place = _skip(text, place)
            if text[place : place + 1] not in (",", "]"):
                raise json.JSONDecodeError("Expecting ',' delimiter", text, place)
            is_over = text[place] == "]"
            place += not is_over
        place = _skip(text, place + 1)


def _item(text: str, place: int) -> tuple[Any, int]:
    try:
        item, end = _VERBATIM.raw_decode(text, _skip(text, place))
    except RecursionError:
        raise _too_deep() from None
    return _checked(item), end


def _skip(text: str, place: int) -> int:
    space = _SPACE.match(text, place)
    return space.end() if space else place


def _checked(value: Any) -> Any:
    """Return a value unless it is too deep or contains half a character."""
    for depth, level in enumerate(levels(value)):
        if depth == DEEPEST:
            raise _too_deep()
        parts = (part if isinstance(part, dict) else (part,) for part in level)
        "".join(text for texts in parts for text in texts if isinstance(text, str)).encode()
    return value


def levels(value: Any) -> Iterator[list[Any]]:
    """Yield the values at each depth of nested lists and dictionaries.

    >>> list(levels({"a": [1, 2]}))
    [[{'a': [1, 2]}], [[1, 2]], [1, 2]]
    """
    level = [value]
    while level:
        yield level
        inner = [each.values() if isinstance(each, dict) else each for each in level if isinstance(each, dict | list)]
        level = [part for each in inner for part in each]


def _too_deep() -> ValueError:
    return ValueError(f"nested deeper than {DEEPEST} levels")


ASKED = "asked.json"


def prepare(root: Path, wanted: Mapping[str, Any], work: str, *, resume: bool) -> None:
    """Create a folder for a request, or reopen it for an interrupted run.

    `wanted` contains the JSON values that determine the results. `work` names the request, such as ``power analysis``.

    Raises `InvalidFile` if the folder contains this request and `resume` is not set, or another request.
    """
    path = root / ASKED
    if path.exists():
        held = json_object(path, f"the request of a {work}; choose another --out")
        other = next((name for name, value in wanted.items() if held.get(name) != value), None)
        if other is not None:
            result, requested = held.get(other), wanted[other]
            raise InvalidFile(
                f"{path}: found {other} {result!r}, expected {requested!r} as requested; choose another --out"
            )
        if not resume:
            raise InvalidFile(f"{root}: found this {work}, expected an empty folder; continue with --resume")
    make_folder(root)
    write_atomically(path, json.dumps({**wanted, "versions": versions()}, indent=2).encode() + b"\n")
