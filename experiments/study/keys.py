"""The keys of a table of a file, as the class that reads it has them: must it be there, what else, in which range.

A range is what the class itself says when it is given what cannot be: nothing here repeats a rule.
"""

import dataclasses
import math
import re
import types
import typing
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from tactometry.config.quantity import unit_in
from tactometry.config.strict import build, fields_of, is_required, words_of
from tactometry.errors import TactometryError

ASKED = "table"
"""The path under which a table is built to hear what it refuses."""
PROBES: Mapping[type, tuple[object, ...]] = {
    float: (-1.0, math.nan, 0.0, 1e4),
    int: (-(10**9), 0, 10**7),
    str: ("?",),
}
"""By the kind of a key, what is likely to be refused: below, nothing at all, at the edge, above."""
OF_EXAMPLE = (
    (r" \([^()]*\)", ""),  # a remark, or the number of another key
    (r"[:;].*", ""),
    (r"^one of index, middle$", "the places"),
    (r"-?[\d.e+]+, (?=[a-z]+(_[a-z]+)+$)", ""),  # the number of the key that is named behind it
    (r" of -?[\d.e+]+ (s|m)\b", ""),
    (r"^at most [\d.]+ s for biphasic pulses at [\d.]+ Hz$", "at most half of the period if biphasic"),
    (r"from (\S+) to inf$", r"at least \1"),
    (r"^(a finite number|a number|a whole number|a level|numbers?)(, | |$)", ""),
)
"""What a refusal says of the values beside it, or what the column of kinds says already."""


@dataclass(frozen=True)
class KeyTable:
    """A table of a file: the class that reads it, and values that it takes.

    Parameters
    ----------
    reads : type
    example : mapping
        A table that is valid, with its required keys at least.
    given : mapping
        Fields that come from elsewhere.
    made : callable
        What is made of it, which may refuse more.
    in_levels : tuple of str
        Keys in the unit of the level.
    kinds : mapping of str to collection of str
        Keys that hold a table of one of these kinds.
    """

    reads: type
    example: Mapping[str, object] = field(default_factory=dict)
    given: Mapping[str, object] = field(default_factory=dict)
    made: Callable[[Any], object] = field(default=lambda built: built)
    in_levels: tuple[str, ...] = ()
    kinds: Mapping[str, Collection[str]] = field(default_factory=dict)


@dataclass(frozen=True)
class Key:
    """A key: what it holds, its unit, in which range, and what is taken if it is left out ("" if it must be there)."""

    name: str
    holds: str
    unit: str
    within: str
    otherwise: str

    @property
    def required(self) -> bool:
        return not self.otherwise


def keys_of(table: KeyTable) -> tuple[Key, ...]:
    """The keys that a file may set, those that must be there first.

    >>> from tactometry.protocols import ForcedChoice
    >>> keys_of(KeyTable(ForcedChoice))
    (Key(name='n_intervals', holds='a whole number', unit='', within='2, 3 or 4', otherwise='2'),)
    """
    hints = typing.get_type_hints(table.reads)
    fields = {name: one for name, one in fields_of(table.reads).items() if name not in table.given}
    keys = [_key(table, one, hints[name]) for name, one in fields.items() if not _in_python_only(hints[name])]
    of_kinds = (
        Key(name, "a table", "", f"its `kind` one of {', '.join(kinds)}", "") for name, kinds in table.kinds.items()
    )
    return tuple(sorted((*of_kinds, *keys), key=lambda key: not key.required))


def _key(table: KeyTable, one: dataclasses.Field[Any], hint: Any) -> Key:
    unit = "of the level" if one.name in table.in_levels else unit_in(one.name)
    return Key(one.name, words_of(hint), unit, ", ".join(_expectations(table, one.name, hint)), _otherwise(one))


def _parts(hint: Any) -> tuple[Any, ...]:
    """The types that a key may have."""
    several = typing.get_origin(hint) in (typing.Union, types.UnionType)
    return typing.get_args(hint) if several else (hint,)


def _in_python_only(hint: Any) -> bool:
    """Whether no table of a file can be made into it."""
    return any(getattr(part, "_is_protocol", False) for part in _parts(hint))


def _expectations(table: KeyTable, name: str, hint: Any) -> Iterator[str]:
    """What the class expects of a key, as it says itself when it is given something else; each said once."""
    said: list[str] = []
    for probe in (probe for kind in _parts(hint) for probe in _probes(kind)):
        expected = _expectation(table, name, probe)
        if expected and not any(expected in other or other in expected for other in said):
            said.append(expected)
            yield expected


def _probes(part: Any) -> tuple[object, ...]:
    """What is of the right type, and likely to be refused."""
    origin, inner = typing.get_origin(part), typing.get_args(part)
    if origin is tuple:
        return ([], *([probe] for probe in PROBES.get(inner[0], ())))
    return PROBES.get(part, ())


def _expectation(table: KeyTable, name: str, probe: object) -> str:
    """What is expected in place of a probe, without values of the example; nothing if the probe is taken."""
    try:
        table.made(build(table.reads, {**table.example, name: probe}, ASKED, **table.given))
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


def _otherwise(one: dataclasses.Field[Any]) -> str:
    if is_required(one):
        return ""
    value = one.default if one.default_factory is dataclasses.MISSING else one.default_factory()
    return _default_text(value)


def _default_text(value: object) -> str:
    """A default as a file would write it."""
    if value is None or value in ((), {}):
        return "none"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, Collection) and not isinstance(value, str):
        return f"[{', '.join(map(_default_text, value))}]"
    return f'"{value}"' if isinstance(value, str) else "its own" if dataclasses.is_dataclass(value) else str(value)
