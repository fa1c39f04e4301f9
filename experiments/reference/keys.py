"""Keys of a table with default, range and meaning, derived from its class.

Ranges are parsed from the errors that the class raises for invalid values, because many depend on other keys.
"""

import dataclasses
import inspect
import math
import re
import types
import typing
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import Any, Final

from tactometry.config.quantity import unit_in
from tactometry.config.strict import fields_of, is_required, words_of
from tactometry.errors import TactometryError

from .tables import KeyTable, inner_name, toml_value

WHERE = "table"
"""Name in errors of a table that is built with an invalid value."""
PROBES: Mapping[type, tuple[object, ...]] = {
    float: (-1.0, math.nan, 0.0, 1e4),
    int: (-(10**9), 0, 10**7),
    str: ("?",),
}
"""Values of each type that are likely to be invalid: below, missing, at the edge, above."""
OF_EXAMPLE = (
    (r" \([^()]*\)", ""),  # a comment, or the value of another key
    (r"[:;].*", ""),
    (r', or "unlimited"$', ""),  # already stated in the column of types
    (r"^one of index, middle$", "the places"),
    (r"-?[\d.e+]+, (?=[a-z]+(_[a-z]+)+$)", ""),  # the value of the key named after it
    (r" of -?[\d.e+]+ (s|m)\b", ""),
    (r"^at most [\d.]+ s for biphasic pulses at [\d.]+ Hz$", "at most half of the period if biphasic"),
    (r"from (\S+) to inf$", r"at least \1"),
    (r"^(a finite number|a number|a whole number|a level|numbers?)(, | |$)", ""),
)
"""Parts of an error to replace, because they state the type or values of the example."""


@dataclass(frozen=True)
class Key:
    """Key of a table, with its type, unit and range.

    `otherwise` is the default, or empty for a required key. `example` is a value in TOML, or empty for an inner table,
    whose keys are listed in the table `see`.
    """

    name: str
    holds: str
    unit: str
    within: str
    otherwise: str
    means: str = ""
    example: str = ""
    see: str = ""

    @property
    def required(self) -> bool:
        return not self.otherwise


def keys_of(table: KeyTable) -> tuple[Key, ...]:
    """Return a table's keys in the order: kind, required keys, optional keys.

    >>> from tactometry.experiments.reference.tables import tables
    >>> [(key.name, key.within, key.otherwise) for key in keys_of(tables()["task.forced_choice"])]
    [('kind', '`"forced_choice"`', ''), ('n_intervals', '2, 3 or 4', '2')]
    """
    hints, given = typing.get_type_hints(table.reader), table.given()
    fields = {name: one for name, one in fields_of(table.reader).items() if name not in given}
    keys = [_key(table, one, hints[name]) for name, one in fields.items() if not _in_python_only(hints[name])]
    of_kinds = [_of_kinds(table, name) for name in table.kinds]
    kind = [_kind(table)] if table.kind else []
    return (*kind, *sorted((*of_kinds, *keys), key=lambda key: not key.required))


def _kind(table: KeyTable) -> Key:
    stated = toml_value(table.kind)
    return Key("kind", "a text", "", f"`{stated}`", stated if table.usual else "", summary(table.reader), stated)


def _of_kinds(table: KeyTable, name: str) -> Key:
    """Return a key whose value is a table of one of several kinds."""
    kinds = f"`kind` is one of {', '.join(table.kinds[name])}"
    means = meanings(table.reader).get(name, "")
    return Key(name, "a table", "", kinds, "", means, toml_value(table.shown[name]), name)


def _key(table: KeyTable, one: dataclasses.Field[Any], hint: Any) -> Key:
    return Key(
        one.name,
        words_of(hint),
        "of the level" if one.name in table.in_levels else unit_in(one.name),
        ", ".join(_expectations(table, one.name, hint)),
        _otherwise(one),
        meanings(table.reader).get(one.name, ""),
        _example(table, one),
        inner_name(table, one.name, _classes(hint)),
    )


def _example(table: KeyTable, one: dataclasses.Field[Any]) -> str:
    """Return an example value of a key, or an empty text for an inner table."""
    for values in (table.shown, table.instead.get(one.name, {}), table.samples):
        if one.name in values:
            return toml_value(values[one.name])
    default = _default(one)
    return "" if default in (None, (), {}) or dataclasses.is_dataclass(default) else toml_value(default)


def _parts(hint: Any) -> tuple[Any, ...]:
    several = typing.get_origin(hint) in (typing.Union, types.UnionType)
    return typing.get_args(hint) if several else (hint,)


def _classes(hint: Any) -> tuple[type, ...]:
    """Return the dataclasses in a key's type, alone or in a container."""
    inner = [each for part in _parts(hint) for each in (part, *typing.get_args(part))]
    return tuple(each for each in inner if isinstance(each, type) and dataclasses.is_dataclass(each))


def _in_python_only(hint: Any) -> bool:
    return any(getattr(part, "_is_protocol", False) for part in _parts(hint))


def _expectations(table: KeyTable, name: str, hint: Any) -> Iterator[str]:
    """Yield the distinct expectations in errors of the class for the probes."""
    expectations: list[str] = []
    for probe in (probe for kind in _parts(hint) for probe in _probes(kind)):
        expected = _expectation(table, name, probe)
        if expected and not any(expected in other or other in expected for other in expectations):
            expectations.append(expected)
            yield expected


def _probes(part: Any) -> tuple[object, ...]:
    """Return values of the right type that are likely to be invalid."""
    origin, inner = typing.get_origin(part), typing.get_args(part)
    if origin is tuple:
        return ([], *([probe] for probe in PROBES.get(inner[0], ())))
    return PROBES.get(part, ())


def _expectation(table: KeyTable, name: str, probe: object) -> str:
    """Return the expectation in the error for a probe, empty if it is valid."""
    try:
        table.read({**table.instead.get(name, table.shown), name: probe}, WHERE)
    except TactometryError as error:
        where, _, rest = str(error).partition(": found ")
        of_this_key = re.fullmatch(rf"(?:.*[.: ])?{name}(\[\d+\])?", where)
        expected = _without_example(rest.partition(", expected ")[2]) if of_this_key else ""
        of_each = of_this_key is not None and of_this_key[1] and expected and not expected.startswith("each")
        return f"each {expected}" if of_each else expected
    return ""


def _without_example(expected: str) -> str:
    for pattern, instead in OF_EXAMPLE:
        expected = re.sub(pattern, instead, expected)
    return expected.strip()


def _default(one: dataclasses.Field[Any]) -> object:
    if is_required(one):
        return None
    return one.default if one.default_factory is dataclasses.MISSING else one.default_factory()


def _otherwise(one: dataclasses.Field[Any]) -> str:
    """Return a key's default in TOML."""
    if is_required(one):
        return ""
    value = _default(one)
    if value in (None, "", (), {}):
        return "none"
    return "its own" if dataclasses.is_dataclass(value) else toml_value(value)


_SECTION: Final = re.compile(r"^Parameters\n-+\n(.*?)(?=^\w[\w ]*\n-{3,}$|^>>> |\Z)", re.MULTILINE | re.DOTALL)
_ENTRY: Final = re.compile(r"^(\w[\w, ]*?)(?: :[^\n]*)?\n((?:[ ]{4}[^\n]*\n|\n)*)", re.MULTILINE)
_ITEM: Final = re.compile(r"^- ((?:`\w+`(?:, )?)+): ([^\n]*\n(?:[ ]{2}[^\n]*\n)*)", re.MULTILINE)
_AS_IN: Final = re.compile(r"^As in `(?:([\w.]+)\.)?(\w+)`")


@cache
def meanings(kind: type) -> Mapping[str, str]:
    """Return the meaning of each key, from docstrings of class and bases.

    If a class has a single key, its first paragraph describes that key.

    >>> from tactometry.observers.changes import SlowLearning
    >>> meanings(SlowLearning)["gain_db"]
    'Deficit of sensitivity at the first trial.'
    """
    of_bases: dict[str, str] = {}
    for base in reversed(kind.__mro__):
        own = _parameters(base)
        of_bases |= {name: text for name, text in own.items() if name not in of_bases or not _AS_IN.match(text)}
    inherited = {name: _followed(kind, name, text) for name, text in of_bases.items()}
    names = list(fields_of(kind))
    return {names[0]: summary(kind), **inherited} if len(names) == 1 else inherited


def summary(kind: type) -> str:
    """Return the first paragraph of a class's docstring on one line.

    >>> from tactometry.protocols.tasks.touch import Pressing
    >>> summary(Pressing)
    'Finger that rests.'
    """
    return " ".join(inspect.cleandoc(kind.__doc__ or "").partition("\n\n")[0].split())


def _parameters(kind: type) -> dict[str, str]:
    text = inspect.cleandoc(vars(kind).get("__doc__") or "") + "\n"
    section = _SECTION.search(text)
    entries = [*_ITEM.findall(text), *(_ENTRY.findall(section[1] + "\n") if section else ())]
    return {name.strip(" `"): " ".join(meaning.split()) for names, meaning in entries for name in names.split(",")}


def _followed(kind: type, name: str, text: str) -> str:
    """Replace ``As in `Other``` at the beginning by the text of `Other`."""
    named = _AS_IN.match(text)
    other = _named_by(kind, named[1], named[2]) if named else None
    if named is None or other is None or name not in meanings(other):
        return text
    rest = text[named.end() :].strip(" .,;")
    return f"{meanings(other)[name]} {rest[:1].upper()}{rest[1:]}".strip()


def _named_by(kind: type, module: str | None, name: str) -> type | None:
    other = getattr(import_module(module or kind.__module__), name, None)
    return other if isinstance(other, type) else None


def heading(table: KeyTable) -> str:
    """Return a table's location in a file, and its description.

    >>> from tactometry.experiments.reference.tables import tables
    >>> heading(tables()["touch.press"])
    '[touch] with kind = "press". Finger that rests.'
    """
    place = table.header or "the top of the file"
    kind = f' with kind = "{table.kind}"' if table.kind else ""
    return " ".join(filter(None, [f"{place}{kind}.", summary(table.reader), table.note]))


def holds(key: Key) -> str:
    """Return a key's type, unit and range as text.

    >>> holds(Key("force_n", "a number", "N", "above 0", ""))
    'a number, N, above 0'
    """
    return ", ".join(filter(None, [key.holds, key.unit, key.within]))


def block(table: KeyTable) -> str:
    """Return an example table in TOML, with optional keys as comments.

    For a file without a header, its inner tables follow.

    >>> from tactometry.experiments.reference.tables import tables
    >>> print(block(tables()["touch.press"]), end="")
    [touch]
    kind = "press"
    force_n = 1.0
    hold_s = 0.3
    timeout_s = 10.0
    # tolerance = 0.15
    """
    return _written(table, *_stated_and_others(table))


def example(table: KeyTable) -> str:
    """Return an example table in TOML with its required keys.

    >>> from tactometry.experiments.reference.tables import tables
    >>> print(example(tables()["limits"]), end="")
    [limits]
    voltage_peak_v = 200.0
    """
    stated, others = _stated_and_others(table)
    return _written(table, stated or others[:1])  # one optional key shows the form of the table


def _stated_and_others(table: KeyTable) -> tuple[list[Key], list[Key]]:
    """Split the keys that have an example into shown ones and others."""
    keys = [key for key in keys_of(table) if key.example]
    stated = [key for key in keys if key.required or key.name in table.shown]
    return stated, [key for key in keys if key not in stated]


def _written(table: KeyTable, stated: list[Key], comments: Sequence[Key] = ()) -> str:
    apart = [] if table.header else [key for key in stated if isinstance(table.shown.get(key.name), Mapping)]
    lines = [f"{key.name} = {key.example}" for key in stated if key not in apart]
    lines += [f"# {key.name} = {key.example}" for key in comments]
    parts = [line for key in apart for line in ("", f"[{key.name}]", *_lines(table.shown[key.name]))]
    return "".join(f"{line}\n" for line in [*filter(None, [table.header]), *lines, *parts])


def _lines(values: Mapping[str, object]) -> list[str]:
    return [f"{name} = {toml_value(value)}" for name, value in values.items()]
