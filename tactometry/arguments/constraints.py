"""Constraints on numbers as data, and their error messages.

The classes of `annotated_types` state a constraint: ``frequency_hz: Annotated[float, Gt(0)]``. `checked` reads it for
the arguments of a call, and `constrained` for the fields of a dataclass built in a call or from a file.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache, lru_cache, partial
from math import inf, isfinite, nextafter
from numbers import Real
from types import UnionType
from typing import Annotated, Any, TypeGuard, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np
from annotated_types import Ge, Gt, Interval, IsFinite

from ..errors import InvalidParameter

DOMAINS: Mapping[str, tuple[float, float]] = {
    "_m": (1e-20, 1e9),
    "_m2": (1e-300, 1e9),
    "_m_per_s": (1e-20, 1e9),
    "_per_m": (1e-9, 1e20),
    "_s": (1e-18, 1e12),
    "_per_s": (0.0, 1e40),
    "_n_s_per_m": (0.0, 1e15),
    "_hz": (1e-12, 1e18),
    "_v": (1e-30, 1e12),
    "_n": (1e-30, 1e50),
    "_kg": (1e-20, 1e9),
    "_n_per_m": (1e-15, 1e20),
    "_ohm": (1e-20, 1e20),
    "_ohm_m": (1e-30, 1e30),
    "_rad": (0.0, 1e9),
    "_per_count": (0.0, 1e9),
    "_share": (0.0, 1e30),
    "_per_v2": (0.0, 1e100),
}
"""Smallest nonzero and largest magnitude by unit suffix, in that unit. The longest matching suffix applies."""

ANY = (1e-30, 1e30)
"""Range of numbers without a unit, or with a unit not listed above."""

LARGEST_COUNT = 2**31

TINY = 5e-324


@lru_cache(maxsize=4096)
def domain(name: str) -> tuple[float, float]:
    """Return the smallest nonzero and the largest magnitude that a name allows.

    >>> domain("Sine.frequency_hz"), domain("level")
    ((1e-12, 1e+18), (1e-30, 1e+30))
    """
    units = [unit for unit in DOMAINS if name.endswith(unit)]
    return DOMAINS[max(units, key=len)] if units else ANY


def is_number(value: Any) -> TypeGuard[float]:
    """Return True for a finite real number that a double can represent.

    >>> is_number(2), is_number(True), is_number(1e400), is_number("2"), is_number(10**400)
    (True, False, False, False, False)
    """
    if type(value) is float:
        return isfinite(value)
    try:
        return not isinstance(value, bool) and isinstance(value, Real) and isfinite(float(value))
    except OverflowError:
        return False


T = TypeVar("T")
Check = Callable[[str, Any], None]

Finite = IsFinite[float]
Positive = Annotated[float, Gt(0)]
PositiveWhole = Annotated[int, Gt(0)]
NotNegative = Annotated[float, Ge(0)]
Share = Annotated[float, Interval(ge=0, le=1)]
Rate = Annotated[float, Interval(ge=0, lt=1)]


@dataclass(frozen=True)
class NumberRange:
    """Numbers that a constraint allows, with their description.

    `sized` is the description in errors on numbers above `floor`, whose magnitude is wrong. For other numbers it is
    `expected`.
    """

    low: float
    high: float
    expected: str
    sized: str
    floor: float
    zero: bool = False
    whole: bool = False

    def check(self, where: str, value: Any) -> None:
        known = is_whole(value) if self.whole else is_number(value)
        if known and (self.low <= value <= self.high or (self.zero and value == 0)):
            return
        words = self.sized if known and value > self.floor else self.expected
        raise InvalidParameter(f"{where}: found {excerpt(value)}, expected {words}")


def number_range(limits: Interval, name: str, whole: bool = False) -> NumberRange:
    """Return the numbers within `limits` and within the domain of `name`.

    A real number may have no limits, a lower bound of 0, or a bound on each side.

    >>> number_range(Interval(gt=0), "Sine.frequency_hz").expected
    'a finite number above 0'
    >>> number_range(Interval(ge=0, lt=1), "Observer.lapse_rate").expected
    'a number from 0 to below 1'
    """
    if whole:
        low = -LARGEST_COUNT if limits.ge is None else limits.ge
        high = LARGEST_COUNT if limits.le is None else limits.le
        at_least, at_most = f"a whole number, at least {low}", f"a whole number, at most {high}"
        return NumberRange(low, high, at_least, at_most, low, whole=True)  # type: ignore[arg-type]

    smallest, largest = domain(name)
    sized = size_words(smallest, largest)
    if limits == Interval():
        return NumberRange(-largest, largest, "a finite number", size_words(0.0, largest), -inf)
    if limits == Interval(gt=0):
        return NumberRange(smallest or TINY, largest, "a finite number above 0", sized, 0.0)
    if limits == Interval(ge=0):
        or_zero = f"0 or {sized}" if smallest else sized
        return NumberRange(smallest, largest, "a finite number, at least 0", or_zero, 0.0, zero=True)

    bounds: Any = limits
    low = bounds.ge if bounds.gt is None else nextafter(bounds.gt, inf)
    high = bounds.le if bounds.lt is None else nextafter(bounds.lt, -inf)
    opening = f"above {bounds.gt:g} and" if bounds.ge is None else f"from {bounds.ge:g} to"
    at_most = "at most " if bounds.ge is None else ""
    closing = f"below {bounds.lt:g}" if bounds.le is None else f"{at_most}{bounds.le:g}"
    words = f"a number {opening} {closing}"
    return NumberRange(low, high, words, words, inf)


def ranges(limits: Interval, whole: bool = False) -> Callable[[str], NumberRange]:
    """Return a cached function from a name to the numbers within `limits`."""
    return lru_cache(maxsize=4096)(partial(number_range, limits, whole=whole))


def constrained(kind: type[T]) -> type[T]:
    """Check the constraints of the fields before ``__post_init__``.

    >>> @dataclass(frozen=True)
    ... @constrained
    ... class Tone:
    ...     frequency_hz: Positive
    >>> Tone(-3.0)
    Traceback (most recent call last):
    tactometry.errors.InvalidParameter: Tone.frequency_hz: found -3.0, expected a finite number above 0
    """
    own: Callable[[T], None] | None = vars(kind).get("__post_init__")

    def check_fields(self: T) -> None:
        owner: Any = type(self)
        for name, check in _field_checks(owner).items():
            check(f"{owner.__name__}.{name}", getattr(self, name))
        if own is not None:
            own(self)

    kind.__post_init__ = check_fields  # type: ignore[attr-defined]
    return kind


@cache
def check_of(hint: Any) -> Check | None:
    """Return the check of a constraint, or None if there is none.

    In a union, a value of another type (None, "unlimited") is valid. A constraint on the items of a tuple
    or dict applies to each item.
    """
    origin, inner = get_origin(hint), get_args(hint)
    if origin is Annotated:
        limits = limits_of(hint)
        if limits is None:
            return None
        range_of = ranges(limits, whole=hint.__origin__ is int and limits.gt is None)
        return lambda where, value: range_of(where).check(where, value)
    if origin in (Union, UnionType):
        check = next(filter(None, map(check_of, inner)), None)
        return check and _check_unless(tuple(part for part in inner if isinstance(part, type)), check)
    if origin in (tuple, dict):
        item = check_of(inner[-1] if origin is dict else inner[0])
        return item and _check_items(item)
    return None


def limits_of(hint: Any) -> Interval | None:
    """Return the bounds stated in the metadata of an annotation, or None."""
    notes = [part for note in hint.__metadata__ for part in (note if isinstance(note, Interval) else (note,))]
    bounds = {name: getattr(note, name) for note in notes for name in ("gt", "ge", "lt", "le") if hasattr(note, name)}
    return Interval(**bounds) if bounds or hint == Finite else None


def is_whole(value: Any) -> bool:
    return isinstance(value, int | np.integer) and not isinstance(value, bool)


def excerpt(value: object) -> str:
    """Show a value on one line of at most 60 characters."""
    return f"{' '.join(repr(value).split()):.60}"


def size_words(low: float, high: float) -> str:
    return f"a number from {low:g} to {high:g}" if low else f"a number of at most {high:g}"


@cache
def _field_checks(kind: type) -> Mapping[str, Check]:
    hints = get_type_hints(kind, include_extras=True)
    return {name: check for name, hint in hints.items() if (check := check_of(hint)) is not None}


def _check_unless(classes: tuple[type, ...], check: Check) -> Check:
    def check_others(where: str, value: Any) -> None:
        if not isinstance(value, classes):
            check(where, value)

    return check_others


def _check_items(check: Check) -> Check:
    def check_each(where: str, value: Any) -> None:
        items = [(f".{key}", item) for key, item in value.items()] if isinstance(value, Mapping) else []
        for place, item in items or [(f"[{place}]", item) for place, item in enumerate(value)]:
            check(f"{where}{place}", item)

    return check_each
