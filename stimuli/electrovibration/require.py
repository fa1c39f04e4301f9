"""Checks of arguments; each failure is one sentence: where, what was found, what was expected."""

from collections.abc import Iterable
from math import isfinite
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tactometry.errors import InvalidParameter, nearest


def finite(owner: str, **values: float) -> None:
    """Each value is a finite number."""
    _each(owner, values, "a finite number", lambda value: True)


def positive(owner: str, **values: float) -> None:
    """Each value is a finite number above 0.

    >>> positive("Sine", frequency_hz=-3)
    Traceback (most recent call last):
    tactometry.errors.InvalidParameter: Sine.frequency_hz: found -3, expected a finite number above 0
    """
    _each(owner, values, "a finite number above 0", lambda value: value > 0)


def non_negative(owner: str, **values: float) -> None:
    """Each value is a finite number, at least 0."""
    _each(owner, values, "a finite number, at least 0", lambda value: value >= 0)


def fraction(owner: str, **values: float) -> None:
    """Each value lies between 0 and 1, both included."""
    _each(owner, values, "a number between 0 and 1", lambda value: 0 <= value <= 1)


def one_of(where: str, found: object, choices: Iterable[object]) -> None:
    """`found` is one of `choices`."""
    choices = tuple(choices)
    if found not in choices:
        names = [str(choice) for choice in choices]
        raise InvalidParameter(
            f"{where}: found {found!r}, expected one of {', '.join(names)}{nearest(str(found), names)}"
        )


def finite_array(where: str, values: ArrayLike) -> NDArray[np.float64]:
    """`values` as an array of finite numbers."""
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise InvalidParameter(f"{where}: found {values!r:.60}, expected finite numbers") from None
    if not np.isfinite(array).all():
        index = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise InvalidParameter(f"{where}{list(index)}: found {array[index]}, expected a finite number")
    return array


def samples(where: str, values: ArrayLike) -> NDArray[np.float64]:
    """`values` as an array (..., n_samples) of finite numbers, with at least one sample."""
    array = finite_array(where, values)
    if array.ndim == 0 or array.shape[-1] == 0:
        raise InvalidParameter(f"{where}: found shape {array.shape}, expected (..., n_samples), at least one sample")
    return array


def _each(owner: str, values: dict[str, float], expected: str, holds: Any) -> None:
    for name, value in values.items():
        if not _is_number(value) or not holds(value):
            raise InvalidParameter(f"{owner}.{name}: found {value!r}, expected {expected}")


def _is_number(value: object) -> bool:
    if type(value) is float:
        return isfinite(value)
    return not isinstance(value, bool) and isinstance(value, Real) and _fits(value)


def _fits(value: Real) -> bool:
    try:
        return isfinite(float(value))
    except OverflowError:
        return False
