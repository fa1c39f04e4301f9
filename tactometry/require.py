"""Numbers that must be finite, whole, above 0 or not below it; words that must be of a list; kinds of values."""

import math
from collections.abc import Collection, Sequence
from typing import Any, TypeGuard

import numpy as np

from tactometry.errors import InvalidParameter, nearest


def is_number(value: object) -> TypeGuard[float]:
    """Whether it is a finite real number; True is none.

    >>> is_number(2), is_number(True), is_number(math.nan), is_number("2")
    (True, False, False, False)
    """
    if isinstance(value, bool) or not isinstance(value, int | float | np.integer | np.floating):
        return False
    return bool(-math.inf < value < math.inf)


def finite(owner: str, **values: object) -> None:
    """Refuse what is not a finite number.

    Raises
    ------
    InvalidParameter
        If a value is not; the sentence names `owner` and the value's name.

    >>> finite("Staircase", low=0.0, high=40.0)
    """
    for name, value in values.items():
        if not is_number(value):
            raise InvalidParameter(f"{owner}.{name}: found {value!r:.60}, expected a finite number")


def numbers(where: str, values: object) -> None:
    """Refuse what is not a sequence of finite numbers, empty or not.

    Raises
    ------
    InvalidParameter
        If it is not; the sentence opens with `where`.

    >>> numbers("Staircase.steps", (4.0, 2.0))
    """
    if not isinstance(values, Sequence) or isinstance(values, str):
        raise InvalidParameter(f"{where}: found {values!r:.60}, expected a sequence of finite numbers")
    for n, value in enumerate(values):
        if not is_number(value):
            raise InvalidParameter(f"{where}[{n}]: found {value!r:.60}, expected a finite number")


def whole(owner: str, *, lowest: int, **values: object) -> None:
    """Refuse what is not a whole number of at least `lowest`.

    Raises
    ------
    InvalidParameter
        As `finite`.

    >>> whole("Staircase", lowest=1, n_trials=60)
    """
    for name, value in values.items():
        if not (isinstance(value, int | np.integer) and not isinstance(value, bool) and value >= lowest):
            raise InvalidParameter(f"{owner}.{name}: found {value!r:.60}, expected a whole number, at least {lowest}")


def of_kind(owner: str, kind: Any, **values: object) -> None:
    """Refuse what is not an instance of `kind`, a class or a protocol that can be asked.

    Raises
    ------
    InvalidParameter
        As `finite`.

    >>> of_kind("QuestPlus", dict, prior={})
    """
    for name, value in values.items():
        if not isinstance(value, kind):
            raise InvalidParameter(f"{owner}.{name}: found {value!r:.60}, expected a {kind.__name__}")


def above_zero(owner: str, **values: object) -> None:
    """Refuse what is not finite and above 0.

    Raises
    ------
    InvalidParameter
        If a value is not; the sentence names `owner` and the value's name.

    >>> above_zero("ForceGate", target_n=1.0, tolerance=0.2)
    """
    for name, value in values.items():
        if not is_number(value) or value <= 0:
            raise InvalidParameter(f"{owner}.{name}: found {value!r:.60}, expected a finite number above 0")


def at_least_zero(owner: str, **values: object) -> None:
    """Refuse what is not finite and at least 0.

    Raises
    ------
    InvalidParameter
        As `above_zero`.

    >>> at_least_zero("ForceGate", hold_s=0.0)
    """
    for name, value in values.items():
        if not is_number(value) or value < 0:
            raise InvalidParameter(f"{owner}.{name}: found {value!r:.60}, expected a finite number, at least 0")


def one_of(where: str, found: str, expected: Collection[str]) -> None:
    """Refuse a word that is none of those expected.

    Raises
    ------
    InvalidParameter
        If it is none; the sentence opens with `where`.

    >>> one_of("QuestPlus.aim", "threshold", ("parameters", "threshold"))
    """
    if found not in expected:
        raise InvalidParameter(
            f"{where}: found {found!r}, expected one of {', '.join(expected)}{nearest(str(found), expected)}"
        )
