"""Checks of arguments; each failure is one sentence: where, what was found, what was expected.

Each number has a domain of magnitude that the unit in its name states (`DOMAINS`): a number that is not 0 and lies
outside of it is a slip of units, and squares and quotients of what lies inside stay within the range of a double.
"""

from collections.abc import Iterable, Mapping
from functools import lru_cache
from math import isfinite
from numbers import Real
from types import NoneType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tactometry.errors import InvalidParameter, nearest

DOMAINS: Mapping[str, tuple[float, float]] = {
    "_m": (1e-20, 1e9),
    "_m2": (1e-300, 1e9),
    "_m_per_s": (1e-20, 1e9),
    "_per_m": (1e-9, 1e20),
    "_s": (1e-18, 1e12),
    "_per_s": (0.0, 1e40),
    "_n_s_per_m": (0.0, 1e15),
    "_hz": (1e-12, 1e18),
    "_v": (0.0, 1e12),
    "_n": (1e-30, 1e50),
    "_kg": (1e-20, 1e9),
    "_n_per_m": (1e-15, 1e15),
    "_ohm": (1e-20, 1e20),
    "_ohm_m": (1e-30, 1e30),
    "_rad": (0.0, 1e9),
    "_share": (0.0, 1e30),
    "_per_v2": (0.0, 1e100),
}
"""Smallest (0 aside) and largest magnitude by the unit of a name, in that unit; the longest that fits holds."""
ANY = (1e-30, 1e30)
"""The domain of a number without unit, or with another one."""

LARGEST_COUNT = 2**31


def finite(owner: str, **values: float) -> None:
    """Each value is a finite number; a sign or a place may be as near to 0 as it likes."""
    for name, value in values.items():
        _check(owner, name, value, "a finite number", holds=True, lowest=0.0)


def positive(owner: str, **values: float) -> None:
    """Each value is a finite number above 0.

    >>> positive("Sine", frequency_hz=-3)
    Traceback (most recent call last):
    tactometry.errors.InvalidParameter: Sine.frequency_hz: found -3, expected a finite number above 0
    >>> positive("Grating", period_m=1e-320)
    Traceback (most recent call last):
    tactometry.errors.InvalidParameter: Grating.period_m: found 1e-320, expected a number from 1e-20 to 1e+09
    """
    for name, value in values.items():
        _check(owner, name, value, "a finite number above 0", holds=_is_number(value) and value > 0)


def non_negative(owner: str, **values: float) -> None:
    """Each value is a finite number, at least 0."""
    for name, value in values.items():
        _check(owner, name, value, "a finite number, at least 0", holds=_is_number(value) and value >= 0)


def fraction(owner: str, **values: float) -> None:
    """Each value lies between 0 and 1, both included."""
    for name, value in values.items():
        _check(owner, name, value, "a number between 0 and 1", holds=_is_number(value) and 0 <= value <= 1, lowest=0.0)


def whole(owner: str, *, lowest: int = -LARGEST_COUNT, **values: int) -> None:
    """Each value is a whole number from `lowest` to `LARGEST_COUNT`."""
    for name, value in values.items():
        known = isinstance(value, int | np.integer) and not isinstance(value, bool)
        if not known or not lowest <= value <= LARGEST_COUNT:
            expected = f"a whole number from {lowest}" + (f" to {LARGEST_COUNT}" if known and value > lowest else "")
            raise InvalidParameter(f"{owner}.{name}: found {value!r:.60}, expected {expected}")


def truth(owner: str, **values: bool) -> None:
    """Each value is True or False."""
    for name, value in values.items():
        if not isinstance(value, bool | np.bool_):
            raise InvalidParameter(f"{owner}.{name}: found {value!r:.60}, expected True or False")


def instance(owner: str, kind: Any, **values: object) -> None:
    """Each value is of a kind: a class, one of a tuple of classes, or a protocol.

    >>> instance("Solution", Real, rate=None)
    Traceback (most recent call last):
    tactometry.errors.InvalidParameter: Solution.rate: found None, expected a value of kind Real
    """
    for name, value in values.items():
        if not isinstance(value, kind):
            kinds = kind if isinstance(kind, tuple) else (kind,)
            names = " or ".join("None" if one is NoneType else str(one.__name__) for one in kinds)
            raise InvalidParameter(f"{owner}.{name}: found {value!r:.60}, expected a value of kind {names}")


def kinds(owner: str, **values: tuple[object, Any]) -> None:
    """Each value, given with its kind, is of it."""
    for name, (value, kind) in values.items():
        if not isinstance(value, kind):
            instance(owner, kind, **{name: value})


def one_of(where: str, found: object, choices: Iterable[object]) -> None:
    """`found` is one of `choices`, texts or numbers; True is not 1."""
    choices = tuple(choices)
    if isinstance(found, bool) or not isinstance(found, str | Real) or found not in choices:
        names = [str(choice) for choice in choices]
        raise InvalidParameter(
            f"{where}: found {found!r:.60}, expected one of {', '.join(names)}{nearest(str(found), names)}"
        )


def finite_array(where: str, values: ArrayLike) -> NDArray[np.float64]:
    """`values` as an array of finite numbers, none larger than the name in `where` allows.

    >>> finite_array("straight.values_v", [0.0, 1e200])
    Traceback (most recent call last):
    tactometry.errors.InvalidParameter: straight.values_v[1]: found 1e+200, expected a number of at most 1e+12
    """
    array, highest = numbers(where, values), _domain(where)[1]
    if not np.abs(array).max(initial=0.0) <= highest:
        index = tuple(int(i) for i in np.argwhere(~(np.abs(array) <= highest))[0])
        expected = f"a number of at most {highest:g}" if np.isfinite(array[index]) else "a finite number"
        raise InvalidParameter(f"{where}{list(index)}: found {array[index]}, expected {expected}")
    return array


def positive_array(where: str, values: ArrayLike) -> NDArray[np.float64]:
    """`values` as an array of finite numbers, none smaller than the name in `where` allows."""
    array, smallest = finite_array(where, values), _domain(where)[0]
    if array.size and not array.min() >= smallest:
        raise InvalidParameter(f"{where}: found {array.min()}, expected numbers from {smallest:g} on")
    return array


def samples(where: str, values: ArrayLike) -> NDArray[np.float64]:
    """`values` as an array (..., n_samples) of finite numbers, with at least one sample."""
    array = finite_array(where, values)
    if array.ndim == 0 or array.size == 0:
        raise InvalidParameter(f"{where}: found shape {array.shape}, expected (..., n_samples), at least one sample")
    return array


def in_range(where: str, result: NDArray[np.float64]) -> NDArray[np.float64]:
    """A result, if a double can hold it."""
    if not np.isfinite(result).all():
        raise InvalidParameter(
            f"{where}: found a result beyond the range of a double, expected arguments of smaller magnitude"
        )
    return result


def numbers(where: str, values: ArrayLike) -> NDArray[np.float64]:
    """`values` as an array of numbers, of any size."""
    try:
        found = np.asarray(values)
        if found.dtype.kind not in "iuf":
            raise TypeError
        return np.asarray(found, dtype=np.float64)
    except (TypeError, ValueError):
        raise InvalidParameter(f"{where}: found {values!r:.60}, expected finite numbers") from None


def _check(owner: str, name: str, value: Any, expected: str, *, holds: bool, lowest: float | None = None) -> None:
    if not (_is_number(value) and holds):
        raise InvalidParameter(f"{owner}.{name}: found {value!r}, expected {expected}")
    smallest, largest = _domain(name)
    smallest = smallest if lowest is None else lowest
    if value != 0 and not smallest <= abs(value) <= largest:
        size = f"a number from {smallest:g} to {largest:g}" if smallest else f"a number of at most {largest:g}"
        or_0 = "0 or " if smallest and not expected.endswith("above 0") else ""
        raise InvalidParameter(f"{owner}.{name}: found {value!r}, expected {or_0}{size}")


@lru_cache
def _domain(name: str) -> tuple[float, float]:
    units = [unit for unit in DOMAINS if name.endswith(unit)]
    return DOMAINS[max(units, key=len)] if units else ANY


def _is_number(value: object) -> bool:
    if type(value) is float:
        return isfinite(value)
    return not isinstance(value, bool) and isinstance(value, Real) and _fits(value)


def _fits(value: Real) -> bool:
    try:
        return isfinite(float(value))
    except OverflowError:
        return False
