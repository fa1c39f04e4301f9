"""Checks of arguments, whose errors state place and expected value.

Functions for numbers accept the owner and then the numbers as keyword arguments, whose names contain the unit and so
the allowed magnitude (`constraints`). Functions for a single value or an array accept the place at the beginning of the
message, then the value.
"""

from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from math import inf, isfinite
from numbers import Real
from types import NoneType
from typing import Any, Final, TypeVar

import numpy as np
from annotated_types import Interval
from numpy.typing import ArrayLike, NDArray

from ..errors import InvalidParameter, TactometryError, nearest
from .constraints import LARGEST_COUNT, NumberRange, domain, excerpt, is_number, number_range, ranges, size_words

V = TypeVar("V")
_FINITE, _POSITIVE, _NOT_NEGATIVE = ranges(Interval()), ranges(Interval(gt=0)), ranges(Interval(ge=0))
_RATE = ranges(Interval(ge=0, lt=1))


def expect(
    holds: bool | np.bool_, where: object, found: object, expected: str, error: type[TactometryError] = InvalidParameter
) -> None:
    """Raise `error` unless a condition is true. `found` is printed as it is.

    >>> expect(0 < 0.5 <= 1, "Scene.accuracy", 0.5, "above 0 and at most 1")
    >>> expect(0 < 2.0 <= 1, "Scene.accuracy", 2.0, "above 0 and at most 1")
    Traceback (most recent call last):
    tactometry.errors.InvalidParameter: Scene.accuracy: found 2.0, expected above 0 and at most 1
    """
    if not holds:
        raise error(f"{where}: found {found}, expected {expected}")


def finite(owner: str, /, **values: object) -> None:
    """Require finite numbers whose magnitudes their units allow."""
    _within(_FINITE, owner, values)


def positive(owner: str, /, **values: object) -> None:
    """Require finite numbers above 0 whose magnitudes their units allow.

    >>> positive("Sine", frequency_hz=-3)
    Traceback (most recent call last):
    tactometry.errors.InvalidParameter: Sine.frequency_hz: found -3, expected a finite number above 0
    """
    _within(_POSITIVE, owner, values)


def not_negative(owner: str, /, **values: object) -> None:
    """Require 0, or numbers that `positive` allows."""
    _within(_NOT_NEGATIVE, owner, values)


def within(owner: str, low: float, high: float, /, **values: object) -> None:
    """Require numbers from `low` to `high`."""
    _within(partial(number_range, Interval(ge=low, le=high)), owner, values)


def between(owner: str, low: float, high: float, /, **values: object) -> None:
    """Require numbers above `low` and below `high`."""
    _within(partial(number_range, Interval(gt=low, lt=high)), owner, values)


def below_1(owner: str, /, **values: object) -> None:
    """Require rates or coefficients of variation, from 0 to below 1."""
    _within(_RATE, owner, values)


def whole(owner: str, /, *, lowest: int = -LARGEST_COUNT, highest: int = LARGEST_COUNT, **values: Any) -> None:
    """Require whole numbers from `lowest` to `highest`."""
    _within(partial(number_range, Interval(ge=lowest, le=highest), whole=True), owner, values)


def not_zero(owner: str, /, **values: object) -> None:
    """Require finite nonzero numbers."""
    _each(owner, values, lambda value: is_number(value) and value != 0, "a finite nonzero number")
    finite(owner, **values)  # its magnitude


def below(owner: str, /, **values: float) -> None:
    """Require that each number is less than the next one."""
    for (name, value), (above, limit) in pairwise(values.items()):
        expect(value < limit, f"{owner}.{name}", f"{value:g}", f"less than {above} ({limit:g})")


def at_most(where: str, found: float, highest: float) -> None:
    """Require a number of at most `highest`."""
    expect(found <= highest, where, f"{found:.6g}", f"at most {highest:.6g}")


def truth(owner: str, /, **values: object) -> None:
    """Require True or False."""
    _each(owner, values, lambda value: isinstance(value, bool | np.bool_), "True or False")


def of_kind(owner: str, kind: Any, /, **values: object) -> None:
    """Require instances of a class, of a tuple of classes or of a protocol."""
    kinds = kind if isinstance(kind, tuple) else (kind,)
    words = " or ".join("None" if each is NoneType else f"a {each.__name__}" for each in kinds)
    _each(owner, values, lambda value: isinstance(value, kinds), words)


def without_none(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values that are not None."""
    return {name: value for name, value in values.items() if value is not None}


def one_of(where: str, found: object, choices: Iterable[object]) -> None:
    """Require one of `choices`, texts or numbers. True does not equal 1."""
    choices = tuple(choices)
    if isinstance(found, bool) or not isinstance(found, str | Real) or found not in choices:
        raise _no_choice(where, found, choices)


def lookup(where: str, name: object, choices: Mapping[str, V]) -> V:
    """Return the item of this name."""
    if isinstance(name, str) and name in choices:
        return choices[name]
    raise _no_choice(where, name, choices)


def some(where: str, found: Sequence[object] | Mapping[Any, object]) -> None:
    """Require at least one item."""
    expect(len(found) > 0, where, "none", "at least one")


def first_repeat(values: Iterable[Hashable]) -> int | None:
    """Return the index of the first repeated value, or None.

    >>> first_repeat((3.0, 1, 3)), first_repeat("abc")
    (2, None)
    """
    seen: set[Hashable] = set()
    for place, value in enumerate(values):
        if value in seen:
            return place
        seen.add(value)
    return None


def distinct(where: str, found: Sequence[float | str], expected: str) -> None:
    """Require distinct values. `expected` ends the error message."""
    place = first_repeat(found)
    if place is not None:
        value = found[place]
        again = repr(value) if isinstance(value, str) else f"{value:g}"
        raise InvalidParameter(f"{where}[{place}]: found {again} twice, expected {expected}")


def numbers(where: str, found: object) -> None:
    """Require a sequence of finite numbers, which may be empty."""
    if not isinstance(found, Sequence) or isinstance(found, str):
        raise InvalidParameter(f"{where}: found {excerpt(found)}, expected a sequence of finite numbers")
    for place, value in enumerate(found):
        if not is_number(value):
            raise InvalidParameter(f"{where}[{place}]: found {excerpt(value)}, expected a finite number")


def as_array(values: Any) -> NDArray[Any] | None:
    """Convert values to an array, or return None if that is impossible."""
    try:
        return np.asarray(values)
    except (TypeError, ValueError):
        return None


def array(where: str, values: ArrayLike) -> NDArray[np.float64]:
    """Return an array of numbers. Infinity and NaN are allowed."""
    result = as_array(values)
    if result is None or result.dtype.kind not in "iuf":
        raise InvalidParameter(f"{where}: found {excerpt(values)}, expected finite numbers")
    return np.asarray(result, dtype=np.float64)


def finite_array(where: str, values: ArrayLike) -> NDArray[np.float64]:
    """Return an array of finite numbers within the domain of its name."""
    return _array_within(where, values, _FINITE(where))


def positive_array(where: str, values: ArrayLike, *, infinite: bool = False) -> NDArray[np.float64]:
    """Return an array of numbers above 0 within the domain of its name.

    With `infinite`, infinity is allowed.
    """
    allowed = _POSITIVE(where)
    return _array_within(where, values, replace(allowed, high=inf) if infinite else allowed)


def not_negative_array(where: str, values: ArrayLike, *, infinite: bool = False) -> NDArray[np.float64]:
    """Return an array of numbers of at least 0, like `positive_array`."""
    high = domain(where)[1]
    allowed = replace(_NOT_NEGATIVE(where), low=0.0, sized=size_words(0.0, high))
    return _array_within(where, values, replace(allowed, high=inf) if infinite else allowed)


def samples(where: str, values: ArrayLike) -> NDArray[np.float64]:
    """Return a finite array (..., n_samples) with at least one sample."""
    found = finite_array(where, values)
    expect(found.ndim > 0 and found.size > 0, where, f"shape {found.shape}", "(..., n_samples), at least one sample")
    return found


def ascending(where: str, values: ArrayLike) -> NDArray[np.float64]:
    """Return a row of at least two finite, ascending numbers."""
    found = finite_array(where, values)
    rises = found.ndim == 1 and len(found) >= 2 and (np.diff(found) > 0).all()
    expect(rises, where, f"shape {found.shape} not in ascending order", "two or more ascending numbers")
    return found


def shape(where: str, values: ArrayLike, shape: tuple[int | None, ...]) -> None:
    """Require a shape, in which None matches any length."""
    result = np.shape(values)
    if len(result) != len(shape) or any(n not in (m, None) for m, n in zip(result, shape, strict=True)):
        words = ", ".join("any" if n is None else str(n) for n in shape)
        raise InvalidParameter(f"{where}: found shape {result}, expected ({words})")


def in_range(where: str, result: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a result, or raise an error if a double cannot represent it."""
    beyond = "a result beyond the range of a double"
    expect(np.isfinite(result).all(), where, beyond, "arguments of smaller magnitude")
    return result


def _each(owner: str, values: Mapping[str, object], fits: Callable[[Any], bool], expected: str) -> None:
    for name, value in values.items():
        if not fits(value):
            raise InvalidParameter(f"{owner}.{name}: found {excerpt(value)}, expected {expected}")


def _within(range_of: Callable[[str], NumberRange], owner: str, values: Mapping[str, object]) -> None:
    for name, value in values.items():
        where = f"{owner}.{name}"
        range_of(where).check(where, value)


def _array_within(where: str, values: ArrayLike, allowed: NumberRange) -> NDArray[np.float64]:
    result = array(where, values)
    if not result.size or (result.min() >= allowed.low and result.max() <= allowed.high):
        return result

    place = tuple(int(i) for i in np.argwhere(~((result >= allowed.low) & (result <= allowed.high)))[0])
    number = result[place]
    words = allowed.sized if isfinite(number) and number > allowed.floor else allowed.expected
    raise InvalidParameter(f"{where}{list(place) if place else ''}: found {number}, expected {words}")


def _no_choice(where: str, found: object, choices: Iterable[object]) -> InvalidParameter:
    names = [str(choice) for choice in choices]
    hint = nearest(str(found), names)
    return InvalidParameter(f"{where}: found {excerpt(found)}, expected one of {', '.join(names)}{hint}")


WORD: Final = "unlimited"

HIGHEST: Final[Mapping[str, float]] = {
    "voltage_peak_v": 5e3,
    "duration_s": 600.0,
    "current_peak_a": 10.0,
    "charge_peak_c": 0.01,
    "displacement_peak_m": 1e-3,
    "session_s": 86_400.0,
    "force_peak_n": 50.0,
    "charge_session_c": 1.0,
    "stop_within_s": 1.0,
    "max_age_days": 3650,
}
"""Plausible upper bounds by key. A larger number would not limit anything (unverified defaults)."""


class Unlimited(float):
    """Limit that is switched off: infinity, stored in files as "unlimited"."""

    def __new__(cls) -> "Unlimited":
        return super().__new__(cls, inf)

    def __reduce__(self) -> tuple[type["Unlimited"], tuple[()]]:
        return Unlimited, ()

    def __str__(self) -> str:
        return WORD

    def __repr__(self) -> str:
        return f"'{WORD}'"


UNLIMITED: Final = Unlimited()


def check_highest(path: str, value: float) -> None:
    """Refuse a limit in a file above its plausible upper bound.

    >>> check_highest("limits.force_peak_n", 1e9)
    Traceback (most recent call last):
    tactometry.errors.InvalidParameter: limits.force_peak_n: found 1e+09, expected at most 50, or "unlimited"
    """
    highest = HIGHEST[path.rpartition(".")[2]]
    if value > highest:
        found = value if isinstance(value, int) else f"{value:.6g}"
        raise InvalidParameter(f'{path}: found {found}, expected at most {highest:g}, or "{WORD}"')


def warning_of(key: str) -> str:
    """Return the warning that a limit is switched off.

    >>> warning_of("limits.force_peak_n")
    'limits.force_peak_n = "unlimited": this limit is switched off'
    """
    return f'{key} = "{WORD}": this limit is switched off'
