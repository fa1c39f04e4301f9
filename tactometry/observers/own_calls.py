"""Calls of an observer of one's own: what its code raises, or answers that is none, is told in one sentence."""

import functools
import math
import sys
import traceback
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from types import NoneType
from typing import Any, Final

import numpy as np

from ..errors import InvalidParameter, TactometryError, reason

WAY: Final = "mend it; what was recorded is safe, --resume goes on from there"


@dataclass(frozen=True)
class Expected:
    """What a method answers, in words, whether a value (of these arguments) is that, and the plain form of it."""

    words: str
    fits: Callable[[Any, tuple[Any, ...]], bool]
    plain: Callable[[Any], Any]


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
MARK: Final = "_is_guarded"


@functools.cache
def guarded(kind: type) -> type:
    """A class as it stands, each of whose calls ends with a plain answer or one sentence.

    Raises
    ------
    InvalidParameter
        By its calls: with file and line, what was raised or answered, and what was expected.
    """
    observer = Expected("an observer (observers/decisions.py)", _is_observer, _of_guarded_class)
    expected = {**ANSWERS, **dict.fromkeys(PEOPLE, observer), **dict.fromkeys(OTHERS)}
    made = type(kind.__name__, (kind,), {"__module__": kind.__module__, "__slots__": (), MARK: True})
    for name, answer in expected.items():
        if callable(getattr(kind, name, None)):
            setattr(made, name, _call(made, name, answer))
    return made


def _call(made: type, name: str, expected: Expected | None) -> Callable[..., Any]:
    kind: Any = made.__base__
    folder = Path(sys.modules[kind.__module__].__file__ or "").parent

    @functools.wraps(getattr(kind, name))
    def call(self: object, *asked: Any, **named: Any) -> Any:
        try:
            value = getattr(super(made, self), name)(*asked, **named)
        except TactometryError:
            raise
        except Exception as error:  # whatever foreign code may raise
            where = place_of(error, folder) or kind.__name__
            found = f"{type(error).__name__} ({reason(error)}) in {name}"
            raise InvalidParameter(f"{where}: found {found}, expected an answer; {WAY}") from None
        if expected is None:
            return value
        if not expected.fits(value, (*asked, *named.values())):
            where, found = _line_of(getattr(kind, name)), f"{value!r} as the answer of {name}"
            raise InvalidParameter(f"{where}: found {found}, expected {expected.words}; {WAY}")
        return expected.plain(value)

    return call


def place_of(error: BaseException, folder: Path) -> str:
    """Which line of a file in a folder raised an error; nothing if none did."""
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if Path(frame.filename).parent == folder]
    return f"{frames[-1].filename}, line {frames[-1].lineno}" if frames else ""


def _line_of(method: Any) -> str:
    code = getattr(method, "__code__", None)
    return f"{code.co_filename}, line {code.co_firstlineno}" if code else str(method)


def _of_guarded_class(observer: Any) -> Any:
    """An observer that own code made, of a class that is guarded too; the house's own need no guard."""
    kind: Any = type(observer)
    if not kind.__module__.startswith("tactometry.") and not hasattr(kind, MARK):
        with suppress(TypeError):  # classes that are written in C are what they are
            object.__setattr__(observer, "__class__", guarded(kind))
    return observer
