"""Meaning of a class and its keys: the first paragraph of its docstring, and its `Parameters` or list of keys."""

import inspect
import re
from collections.abc import Mapping
from functools import cache
from importlib import import_module
from typing import Final

from tactometry.config.strict import fields_of

_SECTION: Final = re.compile(r"^Parameters\n-+\n(.*?)(?=^\w[\w ]*\n-{3,}$|^>>> |\Z)", re.MULTILINE | re.DOTALL)
_ENTRY: Final = re.compile(r"^(\w[\w, ]*?)(?: :[^\n]*)?\n((?:[ ]{4}[^\n]*\n|\n)*)", re.MULTILINE)
_ITEM: Final = re.compile(r"^- ((?:`\w+`(?:, )?)+): ([^\n]*\n(?:[ ]{2}[^\n]*\n)*)", re.MULTILINE)
_AS_IN: Final = re.compile(r"^As in `(?:([\w.]+)\.)?(\w+)`")


@cache
def meanings(kind: type) -> Mapping[str, str]:
    """What each key of a class means, where its docstring or that of a base says so. A class with one key says it in
    its first paragraph.

    >>> from tactometry.observers.changes import SlowLearning
    >>> meanings(SlowLearning)["gain_db"]
    'Loss of sensitivity at the first trial.'
    """
    of_bases: dict[str, str] = {}
    for base in reversed(kind.__mro__):
        own = _parameters(base)
        of_bases |= {name: text for name, text in own.items() if name not in of_bases or not _AS_IN.match(text)}
    said = {name: _followed(kind, name, text) for name, text in of_bases.items()}
    names = list(fields_of(kind))
    return {names[0]: summary(kind), **said} if len(names) == 1 else said


def summary(kind: type) -> str:
    """The first paragraph of its docstring, on one line.

    >>> from tactometry.protocols.tasks.touch import Pressing
    >>> summary(Pressing)
    'A finger that rests.'
    """
    return " ".join(inspect.cleandoc(kind.__doc__ or "").partition("\n\n")[0].split())


def _parameters(kind: type) -> dict[str, str]:
    text = inspect.cleandoc(vars(kind).get("__doc__") or "") + "\n"
    section = _SECTION.search(text)
    entries = [*_ITEM.findall(text), *(_ENTRY.findall(section[1] + "\n") if section else ())]
    return {name.strip(" `"): " ".join(meaning.split()) for names, meaning in entries for name in names.split(",")}


def _followed(kind: type, name: str, text: str) -> str:
    """A text that says ``As in `Other```: what the other class says, and the rest of the text."""
    named = _AS_IN.match(text)
    other = _named_by(kind, named[1], named[2]) if named else None
    if named is None or other is None or name not in meanings(other):
        return text
    rest = text[named.end() :].strip(" .,;")
    return f"{meanings(other)[name]} {rest[:1].upper()}{rest[1:]}".strip()


def _named_by(kind: type, module: str | None, name: str) -> type | None:
    other = getattr(import_module(module or kind.__module__), name, None)
    return other if isinstance(other, type) else None
