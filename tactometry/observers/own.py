"""An observer of one's own: a class in a file beside the study, whose code runs only where a person allowed it."""

import functools
import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from types import NoneType
from typing import Any, Final

import numpy as np

from ..arguments.require import expect
from ..own_code import MARK, Expected, class_beside, guarded, not_allowed
from .decisions import Observer


def _is_number(value: Any, low: float, high: float = math.inf) -> bool:
    is_number = isinstance(value, int | float | np.integer | np.floating)
    return is_number and bool(low <= value <= high) and math.isfinite(value)


def _is_yes_or_no(value: object, _: tuple[Any, ...]) -> bool:
    return isinstance(value, np.bool_) or (isinstance(value, int | np.integer) and value in (0, 1))


def _is_index(value: object, asked: tuple[Any, ...]) -> bool:
    return isinstance(value, int | np.integer) and bool(0 <= value < len(asked[0]))


def _are_facts(value: object, _: tuple[Any, ...]) -> bool:
    return isinstance(value, Mapping) and all(
        isinstance(name, str) and type(fact) in (str, int, float, bool, NoneType) for name, fact in value.items()
    )


def _is_observer(value: object, _: tuple[Any, ...]) -> bool:
    return all(callable(getattr(value, name, None)) for name in ANSWERS)


YES_OR_NO: Final = Expected("True or False", _is_yes_or_no, bool)
INDEX: Final = Expected("the index of one of them, from 0", _is_index, int)
AMOUNT: Final = Expected("a finite number, at least 0", lambda value, _: _is_number(value, 0.0), float)
LIKING: Final = Expected("a number from -1 to 1", lambda value, _: _is_number(value, -1.0, 1.0), float)
FACTS: Final = Expected("a dictionary of plain texts and numbers", _are_facts, dict)
ANSWERS: Final = {
    "detect": YES_OR_NO, "compare": INDEX, "identify": INDEX, "differ": YES_OR_NO, "magnitude": AMOUNT,
    "liking": LIKING, "answer_time_s": AMOUNT, "facts": FACTS,
}  # fmt: skip
"""What an observer is asked; `observers/decisions.py` says what each means."""
PEOPLE: Final = ("participant", "person", "shifted")
"""What makes an observer from one."""
OTHERS: Final = ("stated", "check", "__post_init__")


@functools.cache
def guarded_observer(kind: type) -> type:
    """A class as it stands, each of whose calls ends with a plain answer or one sentence (`own_code.guarded`)."""
    observer = Expected("an observer (observers/decisions.py)", _is_observer, _of_guarded_class)
    return guarded(kind, {**ANSWERS, **dict.fromkeys(PEOPLE, observer), **dict.fromkeys(OTHERS)})


def _of_guarded_class(observer: Any) -> Any:
    """An observer that own code made, of a class that is guarded too; the house's own need no guard."""
    kind: Any = type(observer)
    if not kind.__module__.startswith("tactometry.") and not hasattr(kind, MARK):
        with suppress(TypeError):  # classes that are written in C are what they are
            object.__setattr__(observer, "__class__", guarded_observer(kind))
    return observer


METHODS: Final = ("participant", *ANSWERS)
"""What such a class has."""


@dataclass(frozen=True)
class NotAllowed:
    """An observer whose code is not to run: a study is read, planned, replayed and analysed without it."""

    target: str
    path: str

    def participant(self, rng: np.random.Generator) -> Observer:
        """Nobody."""
        del rng
        raise not_allowed(f"{self.path}.kind", self.target, "an observer")


def own_class(target: str, folder: Path, path: str) -> Any:
    """The class that ``module:Class`` names, from the file of the module in `folder`.

    Raises `InvalidParameter` if there is no such file, its import fails, or it holds no frozen dataclass with the
    methods of an observer; `path` opens the sentence.
    """
    where = f"{path}.kind"
    kind = class_beside(target, folder, where)
    lacking = [method for method in METHODS if not callable(getattr(kind, method, None))]
    found = f"{target!r}, which lacks {', '.join(lacking)}"
    expect(not lacking, where, found, "the methods of an observer (tactometry/observers/decisions.py)")
    return guarded_observer(kind)
