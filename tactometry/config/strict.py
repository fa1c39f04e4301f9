"""Strict conversion of tables of a file to frozen dataclasses."""

import dataclasses
import re
import types
import typing
from collections.abc import Collection, Mapping
from datetime import date
from pathlib import Path
from typing import Any, Final, TypeVar

import msgspec

from ..arguments.require import UNLIMITED, WORD, Unlimited, check_highest
from ..errors import Gathered, InvalidParameter, nearest, nearest_of
from ..loading import resolve
from .toml import errors_in, read_table

T = TypeVar("T")
MOST_HINTS = 100
"""Largest number of unknown keys of a table that get a hint, because each hint requires a search."""
K = TypeVar("K")
_WORDS = {
    float: "a number",
    int: "a whole number",
    str: "a text",
    bool: "true or false",
    date: "a date",
    Unlimited: f'"{WORD}"',
}
_AT = re.compile(r"^(.*?)(?: - at `\$(.*)`)?$")


def build(kind: type[T], table: object, path: str, **given: object) -> T:
    """Build a `kind` from a table that does not contain the `given` fields.

    Raises `InvalidParameter` if a key is unknown, missing or of another type, or if `kind` refuses a value. The
    message starts with the key path.
    """
    values = values_of(kind, table, path, given)
    try:
        return kind(**values, **given)
    except InvalidParameter as error:
        message = str(error)
        relocate = (
            path + message.removeprefix(kind.__name__) if message.startswith(kind.__name__) else f"{path}: {message}"
        )
        raise InvalidParameter(relocate) from None


def values_of(kind: type, table: object, path: str, given: Collection[str] = ()) -> dict[str, Any]:
    """Convert the keys of a table that set fields of `kind`."""
    table = as_table(table, path)
    hints = typing.get_type_hints(kind)
    fields = fields_of(kind)
    names = [name for name in fields if name not in given]
    mistakes, values = Gathered(), {}
    with mistakes.part():
        check_keys(table, names, path, read_by=kind)
    unknown = [key for key in table if key not in names]
    meant = {nearest_of(key, names) for key in unknown[:MOST_HINTS]}
    for name in names:
        if name in table:
            with mistakes.part():
                values[name] = convert(hints[name], table[name], _join(path, name))
        elif is_required(fields[name]) and name not in meant:
            missing = f"{_join(path, name)}: found no such key, expected {words_of(hints[name])}"
            mistakes.add(InvalidKey(missing, kind))
    mistakes.end()
    return values


def build_kind(table: Mapping[str, Any], path: str, targets: Mapping[str, str]) -> Any:
    """Build the class that the key ``kind`` of a table names."""
    target = kind_of(table, path, targets)
    return build(resolve(target), {key: value for key, value in table.items() if key != "kind"}, path)


def kind_of(table: Mapping[str, Any], path: str, known: Mapping[str, K]) -> K:
    """Return the value that the key ``kind`` of a table names.

    >>> kind_of({"kind": "sine"}, "stimulus", {"sine": 1})
    1
    """
    kind = table.get("kind")
    if isinstance(kind, str) and kind in known:
        return known[kind]
    stated, names = "no such key" if kind is None else repr(kind), ", ".join(known)
    sentence = f"{path}.kind: found {stated}, expected one of {names}{nearest(str(kind), known)}"
    raise InvalidKey(sentence) if kind is None else InvalidParameter(sentence)


def as_table(value: object, path: str) -> Mapping[str, Any]:
    """Return a value of a file if it is a table."""
    if isinstance(value, Mapping):
        return value
    raise InvalidParameter(f"{path}: found {value!r}, expected a table")


LOST_LEVEL: Final = "; remove the line if the study has no such level"


class InvalidKey(InvalidParameter):
    """Unknown or missing key of a table that `read_by` reads."""

    def __init__(self, sentence: str, read_by: type | None = None) -> None:
        super().__init__(sentence)
        self.read_by = read_by


def check_keys(
    table: Mapping[str, Any],
    names: Collection[str],
    path: str,
    what: str = "key",
    cure: str = "",
    read_by: type | None = None,
) -> None:
    """Refuse keys that are not among `names`, each with the nearest name.

    - `what`: Noun for the names.
    - `cure`: Another way to correct the file.
    - `read_by`: Class whose fields are the keys.
    """
    mistakes = Gathered()
    unknown = [key for key in table if key not in names]
    for n, key in enumerate(unknown):
        hint = nearest(key, names) if n < MOST_HINTS else ""
        known = f"one of {', '.join(names)}{hint}" if names else "none; remove it"
        mistakes.add(InvalidKey(f"{_join(path, key)}: found an unknown {what}, expected {known}{cure}", read_by))
    mistakes.end()


def read_toml(kind: type[T], path: Path, what: str) -> T:
    """Build a `kind` from a TOML file. `what` describes the file."""
    table = read_table(path, what)
    with errors_in(path):
        return build(kind, table, "")


def convert(kind: Any, value: object, path: str) -> Any:
    """Convert `value` to a plain type, a dataclass or a container of these.

    Raises `InvalidParameter` if the value is of another type. The message starts with the key path.
    """
    of_optional = [choice for choice in typing.get_args(kind) if dataclasses.is_dataclass(choice)]
    table_class = of_optional[0] if typing.get_origin(kind) is types.UnionType and of_optional else kind
    if dataclasses.is_dataclass(table_class) and isinstance(table_class, type):
        return build(table_class, value, path)
    if typing.get_origin(kind) is tuple and isinstance(value, list):
        inner = typing.get_args(kind)[0]
        if dataclasses.is_dataclass(inner):
            return tuple(_each(inner, {f"{path}[{index}]": item for index, item in enumerate(value)}))
    if typing.get_origin(kind) is dict and isinstance(value, Mapping):
        inner = typing.get_args(kind)[1]
        items = value.values() if inner is Any else _each(inner, {_join(path, key): value[key] for key in value})
        return dict(zip(value, items, strict=True))
    if Unlimited in typing.get_args(kind):
        return _limit(kind, value, path)
    try:
        return msgspec.convert(value, kind)
    except msgspec.ValidationError as error:
        match = _AT.match(str(error))
        inner = (match[2] or "") if match else ""
        wrong = _at(value, inner)
        expected = words_of(kind) if not inner else _words_of_error(str(error))
        raise InvalidParameter(f"{path}{inner}: found {_in_toml(wrong)}, expected {expected}") from None


def _each(kind: Any, values: Mapping[str, object]) -> list[Any]:
    mistakes, converted = Gathered(), []
    for path, value in values.items():
        with mistakes.part():
            converted.append(convert(kind, value, path))
    mistakes.end()
    return converted


def _limit(kind: Any, value: object, path: str) -> float | int:
    """Convert a limit, which may be "unlimited"."""
    if value == WORD:
        return UNLIMITED
    number = float if float in typing.get_args(kind) else int
    try:
        limit: float | int = msgspec.convert(value, number)
    except msgspec.ValidationError:
        raise InvalidParameter(f"{path}: found {_in_toml(value)}, expected {words_of(kind)}") from None
    check_highest(path, limit)
    return limit


def fields_of(kind: type) -> dict[str, dataclasses.Field[Any]]:
    """Return the fields of a class that a table may set, by name."""
    fields = dataclasses.fields(kind)
    return {field.name: field for field in fields if field.init and field.name[0] != "_"}


def is_required(field: dataclasses.Field[Any]) -> bool:
    return field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING


def _join(path: str, key: str) -> str:
    return f"{path}.{key}" if path else key


def _at(value: object, inner: str) -> object:
    for index in re.findall(r"\[(\d+)\]", inner):
        value = value[int(index)]  # type: ignore[index]
    return value


def _words_of_error(error: str) -> str:
    match = re.match(r"Expected `([^`]*)`", error)
    words = {kind.__name__: name for kind, name in _WORDS.items()}
    return " or ".join(words.get(name, name) for name in match[1].split(" | ")) if match else error


def _in_toml(value: object) -> str:
    return "true" if value is True else "false" if value is False else repr(value)


def words_of(kind: Any) -> str:
    """Describe a type in words.

    >>> words_of(float), words_of(tuple[str, ...]), words_of(int | None)
    ('a number', 'a list of texts', 'a whole number')
    """
    if kind in _WORDS:
        return _WORDS[kind]
    origin, inner = typing.get_origin(kind), typing.get_args(kind)
    if origin is typing.Literal:
        return "one of " + ", ".join(map(str, inner))
    if origin in (typing.Union, types.UnionType):
        return " or ".join(words_of(choice) for choice in inner if choice is not type(None))
    if origin is tuple:
        return f"a list of {' or '.join(word.removeprefix('a ') + 's' for word in words_of(inner[0]).split(' or '))}"
    return "a table"
