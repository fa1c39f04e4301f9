"""Cells of the trials table: values as text, and rules of columns."""

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from typing import Final

Value = str | int | float | bool | None
LARGEST_ANSWER: Final = 1e15
"""Largest plausible answer. Powers of larger numbers overflow."""


def cell(value: Value) -> str:
    """Format a value as the text of a cell.

    None is empty, a truth value 1 or 0, and a number its shortest exact form.
    """
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(int(value))
    if isinstance(value, float) and value.is_integer() and abs(value) < 1e15:
        return str(int(value))
    return repr(value) if isinstance(value, float) else str(value)


@dataclass(frozen=True)
class CellRule:
    """Description and test of cells that are not empty."""

    words: str
    holds: Callable[[str], bool]


def number_from(low: float, high: float = math.inf) -> Callable[[str], bool]:
    """Return the test for a finite number from `low` to `high`.

    >>> [number_from(0, 1)(text) for text in ("0.5", "2", "nan", "x")]
    [True, False, False, False]
    """

    def holds(text: str) -> bool:
        try:
            return low <= float(text) <= high and math.isfinite(float(text))
        except ValueError:
            return False

    return holds


def one_of_texts(*texts: str) -> Callable[[str], bool]:
    return lambda text: text in texts


def whole_number(highest: float = math.inf) -> Callable[[str], bool]:
    """Return the test for a whole number from 1 to `highest`.

    >>> [whole_number(9)(text) for text in ("1", "0", "10", "1.0")]
    [True, False, False, False]
    """
    return lambda text: re.fullmatch(r"[1-9]\d{0,300}", text) is not None and int(text) <= highest


PARTICIPANT = re.compile(r"[A-Za-z0-9]{1,32}")

STUDY = re.compile(r"[a-z][a-z0-9]*(-[a-z0-9]+)*")


def is_time(text: str) -> bool:
    """Return True for a time in ISO 8601.

    >>> is_time("2026-11-22T14:04:13.059+00:00"), is_time("yesterday")
    (True, False)
    """
    try:
        datetime.fromisoformat(text)
    except ValueError:
        return False
    return True
