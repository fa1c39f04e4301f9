"""Checks of arguments by their annotations and the units in their names."""

import functools
import inspect
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf, isinf
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, NamedTuple, TypeVar, Union, cast, get_args, get_origin

import numpy as np
from annotated_types import Ge, Gt
from numpy.typing import ArrayLike, NDArray

from ..errors import InvalidParameter, nearest
from . import constraints
from .constraints import LARGEST_COUNT, check_of, domain, excerpt, is_number
from .require import as_array, not_negative_array, positive_array

Vector = Annotated[NDArray[np.float64], 1]
Matrix = Annotated[NDArray[np.float64], 2]
Unbounded = Annotated[float, inf]
"""Number that may be infinite."""
UnboundedArray = Annotated[ArrayLike, inf]
UnboundedComplex = Annotated[NDArray[np.complex128], inf]
Positive = constraints.Positive
PositiveWhole = constraints.PositiveWhole
NotNegative = constraints.NotNegative
PositiveArray = Annotated[ArrayLike, Gt(0)]
NotNegativeArray = Annotated[ArrayLike, Ge(0)]

Test = Callable[[Any], bool]
Demand = Callable[[str, Any], object]
SHORT = 2**14


@dataclass(frozen=True)
class AnnotationRule:
    """Test of a value, and its description.

    - `part`: Rule for the items of a container.
    - `good`: Elementwise test for the numbers of an array.
    - `choices`: Allowed texts.
    - `dtype`: Type of the array.
    - `demand`: Check of the sign, which names the place of the value in its error.
    """

    fits: Test
    words: str
    part: "AnnotationRule | None" = None
    good: Callable[[NDArray[Any]], NDArray[np.bool_]] | None = None
    choices: tuple[str, ...] = ()
    dtype: type[np.generic] | None = None
    demand: Demand | None = None


class Bounds(NamedTuple):
    """Tests of numbers up to `high`, or up to infinity if `unbounded`."""

    high: float
    unbounded: bool = False

    def good(self, found: Any) -> NDArray[np.bool_]:
        size = np.abs(found)
        return np.asarray((size <= self.high) | np.isinf(size) if self.unbounded else size <= self.high)

    def number(self, value: Any) -> bool:
        if isinstance(value, float):
            return -self.high <= value <= self.high or (self.unbounded and isinf(value))
        return is_number(value) and -self.high <= value <= self.high

    def array(self, value: Any, kinds: str = "iuf") -> bool:
        result = as_array(value)
        if result is None or result.dtype.kind not in kinds:
            return False
        return _all_within(result, self.high) or bool(self.good(result).all())


@functools.cache
def rule_of(hint: Any, high: float, unbounded: bool = False) -> AnnotationRule:
    """Return the rule for an annotation, for numbers up to `high`.

    >>> rule_of(Sequence[float], 1e9).words
    'a list, each of it a finite number'
    """
    origin, inner, bounds = get_origin(hint), get_args(hint), Bounds(high, unbounded)
    if hint in _PLAIN:
        return _PLAIN[hint]
    if hint in (float, complex, ArrayLike) or origin is np.ndarray:
        return _of_numbers(hint, bounds)
    if origin is Annotated:
        return _annotated(hint, high)
    if origin in (Union, UnionType):
        return _either([rule_of(part, high, unbounded) for part in inner])
    if origin is Literal:
        words = f"one of {', '.join(inner)}"
        return AnnotationRule(lambda value: isinstance(value, str) and value in inner, words, choices=inner)
    if origin is Mapping:
        part = rule_of(inner[1], high, unbounded)
        return AnnotationRule(
            lambda value: isinstance(value, Mapping) and all(map(part.fits, value.values())),
            f"a mapping to {part.words}",
            part=part,
        )
    if origin in (tuple, Sequence, list):
        parts = [rule_of(part, high, unbounded) for part in inner if part is not Ellipsis]
        return _each(parts[0], bounds if inner[0] is float else None) if len(parts) == 1 else _row(parts)
    if isinstance(hint, type):
        return _of_class(hint)
    return AnnotationRule(callable, "a function") if origin is Callable else _PLAIN[Any]


def parts_of(value: Any) -> Iterable[tuple[Any, Any]]:
    """Return each item of a mapping or sequence, with its place."""
    if isinstance(value, Mapping):
        return value.items()
    return enumerate(value) if _is_listed(value) else ()


def _of_numbers(hint: Any, bounds: Bounds) -> AnnotationRule:
    number, good, numbers = bounds.number, bounds.good, "numbers" if bounds.unbounded else "finite numbers"
    if hint is float:
        return AnnotationRule(number, f"a {numbers.removesuffix('s')}", good=good)
    if hint is complex:
        return AnnotationRule(
            lambda value: number(value) or (isinstance(value, complex | np.complexfloating) and bool(good(value))),
            "a number",
            good=good,
        )
    if hint == ArrayLike:
        return AnnotationRule(lambda value: number(value) or bounds.array(value), numbers, good=good)
    dtype = get_args(get_args(hint)[1])[0]
    kinds, prefix = ("iufc", "complex ") if issubclass(dtype, np.complexfloating) else ("iuf", "")
    return AnnotationRule(
        lambda value: _is_listed(value) and bounds.array(value, kinds),
        f"an array of {prefix}{numbers}",
        good=good,
        dtype=dtype,
    )


def _all_within(found: NDArray[Any], high: float) -> bool:
    """Test all values of an array, without copying a long one. NaN fails."""
    if found.size <= SHORT:
        return bool(np.abs(found).max(initial=0.0) <= high)
    if found.dtype.kind == "c":
        return _all_within(found.real, high) and _all_within(found.imag, high)
    return bool(found.min() >= -high and found.max() <= high)


def _annotated(hint: Any, high: float) -> AnnotationRule:
    base, note = hint.__origin__, hint.__metadata__[0]
    demand = _OF_ARRAYS.get(hint) or check_of(hint)
    if demand or note == inf:
        return replace(rule_of(base, high, note == inf), demand=demand)

    rule, least = rule_of(base, high), 1 if note == 1 else 0
    words = f"an array in {note} dimension{'s' * (note > 1)} of finite numbers{', at least one' * least}"
    fits = rule.fits
    return replace(rule, fits=lambda v: fits(v) and np.ndim(v) == note and np.size(v) >= least, words=words)


def _either(rules: Sequence[AnnotationRule]) -> AnnotationRule:
    """Combine rules. The first rule with items or numbers supplies them."""
    tests = [rule.fits for rule in rules]
    firsts = {name: next(filter(None, (getattr(rule, name) for rule in rules)), None) for name in _OF_FIRST}
    choices = tuple(choice for rule in rules for choice in rule.choices)
    words = " or ".join(rule.words for rule in rules)
    return AnnotationRule(lambda value: any(fits(value) for fits in tests), words, choices=choices, **firsts)


def _row(rules: Sequence[AnnotationRule]) -> AnnotationRule:
    def fits(value: Any) -> bool:
        right_length = _is_listed(value) and len(value) == len(rules)
        return right_length and all(rule.fits(part) for rule, part in zip(rules, value, strict=True))

    return AnnotationRule(fits, f"({', '.join(rule.words for rule in rules)})")


def _each(rule: AnnotationRule, bounds: Bounds | None) -> AnnotationRule:
    """Return the rule for a list. Long lists of numbers are tested as an array."""
    words = f"a list, each of it {rule.words}"
    if bounds is None:
        return AnnotationRule(lambda value: _is_listed(value) and all(map(rule.fits, value)), words, part=rule)
    return AnnotationRule(
        lambda value: _is_listed(value) and bounds.array(value) and np.ndim(value) == 1,
        words,
        part=rule,
        good=bounds.good,
    )


def _of_class(kind: type) -> AnnotationRule:
    """Return the rule for a class, which caches types that passed."""
    known: set[type] = set()

    def fits(value: Any) -> bool:
        if type(value) not in known:
            if not isinstance(value, kind):
                return False
            known.add(type(value))
        return True

    return AnnotationRule(fits, f"a {kind.__name__}")


def _is_listed(value: Any) -> bool:
    if isinstance(value, np.ndarray | np.generic):
        return True
    return isinstance(value, Sequence) and not isinstance(value, str)


def _is_whole(value: Any) -> bool:
    return isinstance(value, int | np.integer) and is_number(value) and abs(value) <= LARGEST_COUNT


_OF_FIRST = ("part", "good", "dtype", "demand")
_OF_ARRAYS: Mapping[Any, Demand] = {PositiveArray: positive_array, NotNegativeArray: not_negative_array}
_PLAIN: Mapping[Any, AnnotationRule] = {
    int: AnnotationRule(_is_whole, "a whole number"),
    bool: AnnotationRule(lambda value: isinstance(value, bool | np.bool_), "True or False"),
    str: AnnotationRule(lambda value: isinstance(value, str), "a text"),
    NoneType: AnnotationRule(lambda value: value is None, "None"),
    Any: AnnotationRule(lambda value: True, "anything"),
}


T = TypeVar("T", bound=Callable[..., Any])


def checked(thing: T) -> T:
    """Make a function, or a class with its methods, check its arguments.

    A number must be finite and within the domain of its name (`constraints.domain`). It must not be True or False. An
    `Unbounded` number may be infinite, and a `Positive` number is above 0. Where an array is annotated, a list becomes
    an array. An array may have any number of dimensions. A `Vector` has one dimension and at least one number, a
    `Matrix` two dimensions.

    >>> @checked
    ... def twice(length_m: float) -> float:
    ...     return 2 * length_m
    >>> twice("wide")
    Traceback (most recent call last):
    tactometry.errors.InvalidParameter: twice.length_m: found 'wide', expected a finite number
    >>> twice(1e10)
    Traceback (most recent call last):
    tactometry.errors.InvalidParameter: twice.length_m: found 10000000000.0, expected a number of at most 1e+09
    """
    if not isinstance(thing, type):
        return cast(T, _with_check(thing, thing.__qualname__))
    for name, member in list(vars(thing).items()):
        if name == "__init__":
            setattr(thing, name, _with_check(member, thing.__name__))
        elif not name.startswith("_") and inspect.isfunction(member):
            setattr(thing, name, _with_check(member, member.__qualname__))
        elif not name.startswith("_") and isinstance(member, classmethod):
            setattr(thing, name, classmethod(_with_check(member.__func__, member.__func__.__qualname__)))
    return thing


def _with_check(function: Callable[..., Any], owner: str) -> Callable[..., Any]:
    signature = inspect.signature(function)
    names = tuple(signature.parameters)

    @functools.cache
    def rules() -> tuple[tuple[AnnotationRule | None, ...], Mapping[str, AnnotationRule], Mapping[str, Demand], bool]:
        hints = {name: hint for name, hint in function.__annotations__.items() if name != "return"}
        known = {name: rule_of(hint, domain(name)[1]) for name, hint in hints.items() if not isinstance(hint, str)}
        demands = {name: rule.demand for name, rule in known.items() if rule.demand}
        return tuple(map(known.get, names)), known, demands, any(rule.dtype for rule in known.values())

    @functools.wraps(function)
    def guarded(*args: Any, **kwargs: Any) -> Any:
        by_place, by_name, demands, makes_arrays = rules()
        for rule, value, name in zip(by_place, args, names, strict=False):
            if rule is not None and not rule.fits(value):
                raise _refusal(f"{owner}.{name}", value, rule)
        for name, value in kwargs.items():
            if name in by_name and not by_name[name].fits(value):
                raise _refusal(f"{owner}.{name}", value, by_name[name])
        if demands:
            for name, value in (*zip(names, args, strict=False), *kwargs.items()):
                if name in demands and value is not None:
                    demands[name](f"{owner}.{name}", value)
        if not (makes_arrays and any(isinstance(value, list | tuple) for value in (*args, *kwargs.values()))):
            return function(*args, **kwargs)
        named = {name: _as_array(by_name.get(name), value) for name, value in kwargs.items()}
        return function(*map(_as_array, by_place, args), *args[len(names) :], **named)

    guarded.__signature__ = in_short(signature)  # type: ignore[attr-defined]
    return guarded


def _as_array(rule: AnnotationRule | None, value: Any) -> Any:
    if rule is not None and rule.dtype is not None and isinstance(value, list | tuple):
        return np.asarray(value, rule.dtype)
    return value


def _refusal(where: str, value: Any, rule: AnnotationRule) -> InvalidParameter:
    """Describe the first wrong part of a sequence, a mapping or an array."""
    if rule.part is not None:
        for place, part in parts_of(value):
            if not rule.part.fits(part):
                return _refusal(f"{where}[{place!r}]", part, rule.part)
    result = as_array(value)
    if rule.good is not None and result is not None and result.dtype.kind in "iufc":
        return _refusal_of_numbers(where, result, rule, rule.good(result))
    hint = nearest(value, rule.choices) if isinstance(value, str) else ""
    return InvalidParameter(f"{where}: found {excerpt(value)}, expected {rule.words}{hint}")


def _refusal_of_numbers(
    where: str, found: NDArray[Any], rule: AnnotationRule, good: NDArray[np.bool_]
) -> InvalidParameter:
    if good.all():
        what = f"shape {found.shape}" if found.ndim else excerpt(found.item())
        return InvalidParameter(f"{where}: found {what}, expected {rule.words}")
    place = tuple(int(i) for i in np.argwhere(~good)[0])
    number, high = found[place], domain(where.partition("[")[0])[1]
    kind = "a finite number" if "finite" in rule.words else "a number"
    expected = f"a number of at most {high:g}" if np.isfinite(number) else kind
    return InvalidParameter(f"{where}{list(place) if place else ''}: found {number}, expected {expected}")


def in_short(signature: inspect.Signature) -> inspect.Signature:
    """Shorten the annotations of a signature as `help` shows it.

    >>> from annotated_types import Gt
    >>> def force_n(voltage_v: ArrayLike, area_m2: Annotated[float, Gt(0)] = 1e-4) -> NDArray[np.float64]: ...
    >>> str(in_short(inspect.signature(force_n)))
    "(voltage_v: 'ArrayLike', area_m2: 'float' = 0.0001) -> 'NDArray[float64]'"
    """
    named = [each.replace(annotation=_name(each.annotation)) for each in signature.parameters.values()]
    return signature.replace(parameters=named, return_annotation=_name(signature.return_annotation))


def _name(annotation: Any) -> Any:
    if get_origin(annotation) is Annotated:
        base = annotation.__origin__
        return _SHORT.get(base) or base.__name__
    return _SHORT.get(annotation, annotation)


_SHORT: Mapping[Any, str] = {
    ArrayLike: "ArrayLike",
    NDArray[np.float64]: "NDArray[float64]",
    NDArray[np.complex128]: "NDArray[complex128]",
}
