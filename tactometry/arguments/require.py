"""Checks of arguments; errors state place, found and expected value.

Numbers are given by name after their owner; the unit in the name sets their domain (`magnitudes`). A single value or an
array is given after the place that opens its message.
"""

from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from math import inf, isfinite
from numbers import Real
from types import NoneType
from typing import Any, TypeVar

import numpy as np
from annotated_types import Interval
from numpy.typing import ArrayLike, NDArray

from ..errors import InvalidParameter, TactometryError, nearest
from .constraints import NumberRange, excerpt, number_range, ranges, size_words
from .magnitudes import LARGEST_COUNT, domain, is_number

V = TypeVar("V")
_FINITE, _POSITIVE, _NOT_NEGATIVE = ranges(Interval()), ranges(Interval(gt=0)), ranges(Interval(ge=0))
_RATE = ranges(Interval(ge=0, lt=1))


def expect(
    holds: bool | np.bool_, where: object, found: object, expected: str, error: type[TactometryError] = InvalidParameter
) -> None:
    """Raise `error` unless a condition holds; `found` is printed as it is.

    >>> expect(0 < 0.5 <= 1, "Scene.accuracy", 0.5, "above 0 and at most 1")
    >>> expect(0 < 2.0 <= 1, "Scene.accuracy", 2.0, "above 0 and at most 1")
    Traceback (most recent call last):
    tactometry.errors.InvalidParameter: Scene.accuracy: found 2.0, expected above 0 and at most 1
    """
    if not holds:
        raise error(f"{where}: found {found}, expected {expected}")


def finite(owner: str, /, **values: object) -> None:
    """Require finite numbers, none larger than its unit allows.

    >>> finite("Staircase", low=0.0, high=40.0)
    """
    _within(_FINITE, owner, values)


def positive(owner: str, /, **values: object) -> None:
    """Require finite numbers above 0 of a magnitude that their units allow.

    >>> positive("Sine", frequency_hz=-3)
    Traceback (most recent call last):
    tactometry.errors.InvalidParameter: Sine.frequency_hz: found -3, expected a finite number above 0
    >>> positive("Grating", period_m=1e-320)
    Traceback (most recent call last):
    tactometry.errors.InvalidParameter: Grating.period_m: found 1e-320, expected a number from 1e-20 to 1e+09
    """
    _within(_POSITIVE, owner, values)


def not_negative(owner: str, /, **values: object) -> None:
    """Require 0 or numbers as `positive` does.

    >>> not_negative("ForceGate", hold_s=0.0)
    """
    _within(_NOT_NEGATIVE, owner, values)


def within(owner: str, low: float, high: float, /, **values: object) -> None:
    """Require numbers from `low` to `high`.

    >>> within("Grating", 0, 1, duty=1.5)
    Traceback (most recent call last):
    tactometry.errors.InvalidParameter: Grating.duty: found 1.5, expected a number from 0 to 1
    """
    _within(partial(number_range, Interval(ge=low, le=high)), owner, values)


def below(owner: str, /, **values: float) -> None:
    """Require that each number is less than the next one.

    >>> below("Staircase", low=40.0, high=0.0)
    Traceback (most recent call last):
    tactometry.errors.InvalidParameter: Staircase.low: found 40, expected less than high (0)
    """
    for (name, value), (above, limit) in pairwise(values.items()):
        expect(value < limit, f"{owner}.{name}", f"{value:g}", f"less than {above} ({limit:g})")


def not_zero(owner: str, /, **values: object) -> None:
    """Require finite numbers other than 0.

    >>> not_zero("ForceCalibration", newtons_per_count=0.0)
    Traceback (most recent call last):
    tactometry.errors.InvalidParameter: ForceCalibration.newtons_per_count: found 0.0, expected a finite number but 0
    """
    _each(owner, values, lambda value: is_number(value) and value != 0, "a finite number but 0")
    finite(owner, **values)  # its magnitude


def between(owner: str, low: float, high: float, /, **values: object) -> None:
    _within(partial(number_range, Interval(gt=low, lt=high)), owner, values)


def below_1(owner: str, /, **values: object) -> None:
    """Require numbers from 0 to below 1: a rate, or a coefficient of variation.

    >>> below_1("Observer", lapse_rate=1.0)
    Traceback (most recent call last):
    tactometry.errors.InvalidParameter: Observer.lapse_rate: found 1.0, expected a number from 0 to below 1
    """
    _within(_RATE, owner, values)


def whole(owner: str, /, *, lowest: int = -LARGEST_COUNT, highest: int = LARGEST_COUNT, **values: Any) -> None:
    """Require whole numbers from `lowest` to `highest`.

    >>> whole("Staircase", lowest=1, n_trials=0)
    Traceback (most recent call last):
    tactometry.errors.InvalidParameter: Staircase.n_trials: found 0, expected a whole number, at least 1
    """
    _within(partial(number_range, Interval(ge=lowest, le=highest), whole=True), owner, values)


def truth(owner: str, /, **values: object) -> None:
    """Require True or False."""
    _each(owner, values, lambda value: isinstance(value, bool | np.bool_), "True or False")


def of_kind(owner: str, kind: Any, /, **values: object) -> None:
    """Require instances of a class, of one of a tuple of classes, or of a protocol.

    >>> of_kind("Solution", Real, rate=None)
    Traceback (most recent call last):
    tactometry.errors.InvalidParameter: Solution.rate: found None, expected a Real
    """
    kinds = kind if isinstance(kind, tuple) else (kind,)
    _each(owner, values, lambda value: isinstance(value, kinds), class_names(kinds))


def at_most(where: str, found: float, highest: float) -> None:
    """Require a number that is not above `highest`.

    >>> at_most("modes below f_max_hz", 2e6, 1e6)
    Traceback (most recent call last):
    tactometry.errors.InvalidParameter: modes below f_max_hz: found 2e+06, expected at most 1e+06
    """
    expect(found <= highest, where, f"{found:.6g}", f"at most {highest:.6g}")


def without_none(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values that are not None."""
    return {name: value for name, value in values.items() if value is not None}


def one_of(where: str, found: object, choices: Iterable[object]) -> None:
    """Require one of `choices`, texts or numbers; True is not 1.

    >>> one_of("QuestPlus.aim", "threshold", ("parameters", "threshold"))
    """
    choices = tuple(choices)
    if isinstance(found, bool) or not isinstance(found, str | Real) or found not in choices:
        raise _no_choice(where, found, choices)


def lookup(where: str, name: object, choices: Mapping[str, V]) -> V:
    """Return the choice of this name.

    >>> lookup("sensor", "hand", {"hand": 1}), lookup("sensor", "hnad", {"hand": 1})
    Traceback (most recent call last):
    tactometry.errors.InvalidParameter: sensor: found 'hnad', expected one of hand; did you mean 'hand'?
    """
    if isinstance(name, str) and name in choices:
        return choices[name]
    raise _no_choice(where, name, choices)


def some(where: str, found: Sequence[object] | Mapping[Any, object]) -> None:
    expect(len(found) > 0, where, "none", "at least one")


def first_repeat(values: Iterable[Hashable]) -> int | None:
    """Return the index of the first value that occurred before, or None.

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
    """Require distinct values; `expected` ends the error message.

    >>> distinct("Staircase.steps", (4.0, 2.0, 4.0), "each step once")
    Traceback (most recent call last):
    tactometry.errors.InvalidParameter: Staircase.steps[2]: found 4 twice, expected each step once
    """
    place = first_repeat(found)
    if place is not None:
        value = found[place]
        again = repr(value) if isinstance(value, str) else f"{value:g}"
        raise InvalidParameter(f"{where}[{place}]: found {again} twice, expected {expected}")


def numbers(where: str, found: object) -> None:
    """Require a sequence of finite numbers, which may be empty.

    >>> numbers("Staircase.steps", (4.0, 2.0))
    """
    if not isinstance(found, Sequence) or isinstance(found, str):
        raise InvalidParameter(f"{where}: found {excerpt(found)}, expected a sequence of finite numbers")
    for place, value in enumerate(found):
        if not is_number(value):
            raise InvalidParameter(f"{where}[{place}]: found {excerpt(value)}, expected a finite number")


def array(where: str, values: ArrayLike) -> NDArray[np.float64]:
    """Return an array of numbers of any size; infinity and NaN are allowed."""
    try:
        found = np.asarray(values)
        if found.dtype.kind not in "iuf":
            raise TypeError
        return np.asarray(found, dtype=np.float64)
    except (TypeError, ValueError):
        raise InvalidParameter(f"{where}: found {excerpt(values)}, expected finite numbers") from None


def finite_array(where: str, values: ArrayLike) -> NDArray[np.float64]:
    """Return an array of finite numbers, none larger than the name in `where` allows.

    >>> finite_array("straight.values_v", [0.0, 1e200])
    Traceback (most recent call last):
    tactometry.errors.InvalidParameter: straight.values_v[1]: found 1e+200, expected a number of at most 1e+12
    """
    return _array_within(where, values, _FINITE(where))


def positive_array(where: str, values: ArrayLike, *, infinite: bool = False) -> NDArray[np.float64]:
    """Return an array of numbers above 0 of a magnitude that the name in `where` allows.

    With `infinite`, infinity is allowed.
    """
    allowed = _POSITIVE(where)
    return _array_within(where, values, replace(allowed, high=inf) if infinite else allowed)


def not_negative_array(where: str, values: ArrayLike, *, infinite: bool = False) -> NDArray[np.float64]:
    """Return an array of numbers of at least 0, however small, as `positive_array` does."""
    high = domain(where)[1]
    allowed = replace(_NOT_NEGATIVE(where), low=0.0, sized=size_words(0.0, high))
    return _array_within(where, values, replace(allowed, high=inf) if infinite else allowed)


def samples(where: str, values: ArrayLike) -> NDArray[np.float64]:
    """Return an array (..., n_samples) of finite numbers with at least one sample."""
    found = finite_array(where, values)
    expect(found.ndim > 0 and found.size > 0, where, f"shape {found.shape}", "(..., n_samples), at least one sample")
    return found


def ascending(where: str, values: ArrayLike) -> NDArray[np.float64]:
    """Return a row of at least two finite, ascending numbers."""
    found = finite_array(where, values)
    rises = found.ndim == 1 and len(found) >= 2 and (np.diff(found) > 0).all()
    expect(rises, where, f"shape {found.shape} not ascending", "two or more ascending numbers")
    return found


def shape(where: str, values: ArrayLike, shape: tuple[int | None, ...]) -> None:
    """Require a shape, in which None matches any length.

    >>> shape("field_m", [1.0, 2.0], (3,))
    Traceback (most recent call last):
    tactometry.errors.InvalidParameter: field_m: found shape (2,), expected (3)
    """
    found = np.shape(values)
    if len(found) != len(shape) or any(n not in (m, None) for m, n in zip(found, shape, strict=True)):
        words = ", ".join("any" if n is None else str(n) for n in shape)
        raise InvalidParameter(f"{where}: found shape {found}, expected ({words})")


def in_range(where: str, result: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a result, or raise if a double cannot represent it."""
    beyond = "a result beyond the range of a double"
    expect(np.isfinite(result).all(), where, beyond, "arguments of smaller magnitude")
    return result


def class_names(kinds: Iterable[type]) -> str:
    """Describe an instance of some classes: "a Plate", "a Layer or None"."""
    return " or ".join("None" if kind is NoneType else f"a {kind.__name__}" for kind in kinds)


def _each(owner: str, values: Mapping[str, object], fits: Callable[[Any], bool], expected: str) -> None:
    for name, value in values.items():
        if not fits(value):
            raise InvalidParameter(f"{owner}.{name}: found {excerpt(value)}, expected {expected}")


def _within(range_of: Callable[[str], NumberRange], owner: str, values: Mapping[str, object]) -> None:
    for name, value in values.items():
        where = f"{owner}.{name}"
        range_of(where).check(where, value)


def _array_within(where: str, values: ArrayLike, allowed: NumberRange) -> NDArray[np.float64]:
    found = array(where, values)
    if not found.size or (found.min() >= allowed.low and found.max() <= allowed.high):
        return found

    place = tuple(int(i) for i in np.argwhere(~((found >= allowed.low) & (found <= allowed.high)))[0])
    number = found[place]
    words = allowed.sized if isfinite(number) and number > allowed.floor else allowed.expected
    raise InvalidParameter(f"{where}{list(place) if place else ''}: found {number}, expected {words}")


def _no_choice(where: str, found: object, choices: Iterable[object]) -> InvalidParameter:
    names = [str(choice) for choice in choices]
    hint = nearest(str(found), names)
    return InvalidParameter(f"{where}: found {excerpt(found)}, expected one of {', '.join(names)}{hint}")
