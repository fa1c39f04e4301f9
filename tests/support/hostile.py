"""Invalid values for one argument at a time: a call gives finite numbers, or refuses in one sentence."""

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import fields, is_dataclass
from inspect import getattr_static, getmembers, isfunction, signature
from math import inf, nan
from typing import Any, NamedTuple

import numpy as np

from tactometry.errors import TactometryError
from tactometry.stimuli.composition.effect import Effect

NO_NUMBERS: Mapping[str, Any] = {"None": None, "a text": "wide", "nan": nan, "inf": inf}
"""A refusal of these names the argument."""
HOSTILE: Mapping[str, Any] = {
    **NO_NUMBERS,
    **{str(value): value for value in (-inf, -1, 0, 1e-320, -1e-320, 1e-200, 1e200, 1e308, True, 1j)},
    **{str(value): value for value in ([], [nan], [1e308, -1e308], [1.0, None], [0.5, 1.0], {})},
    "an empty text": "",
    "10**400": 10**400,
    "-10**30": -(10**30),
    "an object": object(),
}


class Call(NamedTuple):
    """A valid call: what is called, and with what."""

    function: Callable[..., Any]
    arguments: dict[str, Any]


def call_of(function: Callable[..., Any], name: str, arguments: Mapping[str, Any], own: Mapping[str, Any]) -> Call:
    """Find the arguments of a function: in `own` by function and parameter, else by the name of the parameter."""
    given = {
        each: own.get(f"{name}.{each}", arguments.get(each, parameter.default))
        for each, parameter in signature(function).parameters.items()
    }
    return Call(function, given)


def methods(kind: type) -> Iterator[str]:
    """Yield the public methods of a class, without those that a scene calls of an effect."""
    for name in dir(kind):
        member = getattr_static(kind, name)
        of_user = not (name.startswith("_") or (issubclass(kind, Effect) and hasattr(Effect, name)))
        if of_user and (isfunction(member) or isinstance(member, classmethod)):
            yield name


def valid_arguments(instance: Any) -> dict[str, Any]:
    """Return the arguments of a dataclass from a valid instance of it."""
    return {field.name: getattr(instance, field.name) for field in fields(instance) if field.init}


def faults(result: Any, where: str, unbounded: Collection[str] = (), depth: int = 0) -> Iterator[str]:
    """Yield each NaN and infinity in a result, in its fields and in its properties.

    Values with a name in `unbounded` may be infinite.
    """
    if isinstance(result, float | complex | np.ndarray | np.generic):
        array = np.asarray(result)
        if array.dtype.kind in "fc":
            may_be_infinite = where.rpartition(".")[2] in unbounded
            bad = np.isnan(array) if may_be_infinite else ~np.isfinite(array)
            yield from [f"{where} is {result}"] if bad.any() else []
    elif isinstance(result, list | tuple | Iterator):
        for part in result:
            yield from faults(part, where, unbounded, depth)
    elif is_dataclass(result) and not isinstance(result, type) and depth < 3:
        properties = [name for name, _ in getmembers(type(result), lambda member: isinstance(member, property))]
        for name in [field.name for field in fields(result)] + properties:
            yield from faults(getattr(result, name), f"{where}.{name}", unbounded, depth + 1)


def spoilt(value: Any) -> Iterator[tuple[str, Any]]:
    """Yield hostile values for an argument, and for the first of its elements."""
    yield from HOSTILE.items()
    if isinstance(value, list | tuple) and value:
        yield from ((f"[{name}, ...]", type(value)((bad, *value[1:]))) for name, bad in HOSTILE.items())
    if isinstance(value, dict) and value:
        yield from ((f"{{{name}, ...}}", {**value, next(iter(value)): bad}) for name, bad in HOSTILE.items())


def complaint(
    name: str, call: Callable[..., Any], arguments: Mapping[str, Any], named: str, unbounded: Collection[str]
) -> str:
    """Return what is wrong with the answer to hostile arguments, or an empty text. A refusal contains `named`."""
    try:
        return "; ".join(faults(call(**arguments), name, unbounded))
    except TactometryError as refusal:
        said = str(refusal)
        read = "cannot be read (" in said
        states = "found" in said and ("expected" in said or "above the" in said)
        clear = (read or states) and "\n" not in said and len(said) < 600
        return "" if clear and (named in said or read) else f"unclear: {said[:200]}"
    except Exception as error:
        return f"{type(error).__name__}: {error!s:.150}"


def complaints(
    name: str, call: Callable[..., Any], valid: Mapping[str, Any], unbounded: Collection[str], *, names: bool = True
) -> list[str]:
    """Replace one argument of a valid call at a time, and list what is wrong with the answers.

    Without `names`, a refusal need not name its argument.
    """
    found = []
    for argument, value in valid.items():
        for word, bad in spoilt(value):
            named = argument if names and word in NO_NUMBERS else ""
            wrong = complaint(name, call, {**valid, argument: bad}, named, unbounded)
            found += [f"{name}({argument}={word}): {wrong}"] if wrong else []
    return found
