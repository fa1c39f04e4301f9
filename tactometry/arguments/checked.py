"""Checks of arguments by their annotations and the units in their names."""

import functools
import inspect
from collections.abc import Callable, Mapping
from typing import Annotated, Any, TypeVar, cast, get_origin

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InvalidParameter, nearest
from .annotations import AnnotationRule, Demand, parts_of, rule_of
from .constraints import excerpt
from .magnitudes import domain
from .require import as_array

T = TypeVar("T", bound=Callable[..., Any])


def checked(thing: T) -> T:
    """Make a function, or a class with its methods, check its arguments.

    A number must be finite and within the domain of its name (`magnitudes`). It must not be True or False. An
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
    found = as_array(value)
    if rule.good is not None and found is not None and found.dtype.kind in "iufc":
        return _refusal_of_numbers(where, found, rule, rule.good(found))
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
