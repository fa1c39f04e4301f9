"""Arguments checked by what their annotations and names say: the kind by the annotation, the domain by the unit.

What else must hold (above 0, ascending, not longer than) each function and constructor says itself.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from functools import cache, wraps
from inspect import signature
from itertools import chain
from types import NoneType, UnionType
from typing import Any, Literal, ParamSpec, TypeVar, Union, get_args, get_origin

import numpy as np
from numpy.typing import ArrayLike

from tactometry import require
from tactometry.errors import InvalidParameter

P = ParamSpec("P")
R = TypeVar("R")
Check = Callable[[str, str, Any], object]
SCALARS: Mapping[object, Check] = {
    float: lambda owner, name, value: require.finite(owner, **{name: value}),
    int: lambda owner, name, value: require.whole(owner, **{name: value}),
    bool: lambda owner, name, value: require.truth(owner, **{name: value}),
    ArrayLike: lambda owner, name, value: require.finite_array(f"{owner}.{name}", value),
}


def checked(function: Callable[P, R]) -> Callable[P, R]:
    """The function, with every argument checked as `check_of` its annotation.

    >>> @checked
    ... def twice(width_m: float) -> float:
    ...     return 2 * width_m
    >>> twice("wide")
    Traceback (most recent call last):
    tactometry.errors.InvalidParameter: twice.width_m: found 'wide', expected a finite number
    """
    owner, names = function.__qualname__, tuple(signature(function).parameters)
    checks = {name: check_of(annotation) for name, annotation in function.__annotations__.items() if name != "return"}

    @wraps(function)
    def call(*arguments: P.args, **named: P.kwargs) -> R:
        for name, value in chain(zip(names, arguments, strict=False), named.items()):
            if name in checks:
                checks[name](owner, name, value)
        return function(*arguments, **named)

    return call


def check_fields(record: Any) -> None:
    """Check every field of a dataclass as `check_of` its annotation."""
    kind: Any = type(record)
    for name, check in _field_checks(kind):
        check(kind.__name__, name, getattr(record, name))


@cache
def _field_checks(kind: Any) -> tuple[tuple[str, Check], ...]:
    return tuple((field.name, check_of(field.type)) for field in fields(kind))


def check_of(annotation: Any) -> Check:
    """The check of an annotation; none of a text, a literal or a callable, which have sentences of their own."""
    if annotation in SCALARS:
        return SCALARS[annotation]
    origin, parts = get_origin(annotation), get_args(annotation)
    if origin in (UnionType, Union):
        return _optional(parts)
    if origin is np.ndarray:
        return _array
    if origin in (tuple, Sequence):
        return _floats if parts[0] is float else _each(check_of(parts[0]))
    if origin is Mapping:
        return _values(check_of(parts[1]))
    if origin is Literal or not isinstance(annotation, type) or annotation is str:
        return _anything
    return lambda owner, name, value: require.of_kind(owner, annotation, **{name: value})


def _optional(parts: tuple[Any, ...]) -> Check:
    kinds = [part for part in parts if part is not NoneType]
    if len(kinds) > 1 and all(isinstance(kind, type) for kind in kinds):
        return lambda owner, name, value: require.of_kind(owner, tuple(parts), **{name: value})
    check = check_of(kinds[0])
    return lambda owner, name, value: (value is None and NoneType in parts) or check(owner, name, value)


def _array(owner: str, name: str, value: Any) -> None:
    require.of_kind(owner, (np.ndarray, np.generic), **{name: value})
    if value.dtype.kind == "c":
        require.finite_array(f"{owner}.{name}", np.abs(value))
    else:
        require.finite_array(f"{owner}.{name}", value)


def _floats(owner: str, name: str, value: Any) -> None:
    if require.finite_array(f"{owner}.{name}", value).ndim != 1:
        raise InvalidParameter(f"{owner}.{name}: found {value!r:.60}, expected a row of numbers")


def _each(check: Check) -> Check:
    def check_each(owner: str, name: str, value: Any) -> None:
        if not isinstance(value, Sequence) or isinstance(value, str):
            raise InvalidParameter(f"{owner}.{name}: found {value!r:.60}, expected a sequence")
        for place, one in enumerate(value):
            check(owner, f"{name}[{place}]", one)

    return check_each


def _values(check: Check) -> Check:
    def check_values(owner: str, name: str, value: Any) -> None:
        require.of_kind(owner, Mapping, **{name: value})
        for key, one in value.items():
            check(owner, f"{name}[{key!r}]", one)

    return check_values


def _anything(owner: str, name: str, value: Any) -> None:
    del owner, name, value
