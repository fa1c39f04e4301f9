"""Arguments that are not of the annotated type, each refused in one sentence before anything is computed with them."""

import functools
import inspect
import math
import reprlib
import types
import typing
from collections.abc import Callable, Mapping, Sequence
from typing import Annotated, Any, Final, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tactometry.errors import InvalidParameter

T = TypeVar("T", bound=Callable[..., Any])
Rule = tuple[Callable[[Any], bool], str]

Vector = Annotated[NDArray[np.float64], 1]
Matrix = Annotated[NDArray[np.float64], 2]

LARGEST: Final = 1e30
"""No quantity of a screen in SI units is larger; its powers and products stay finite."""


def checked(thing: T) -> T:
    """A function, or a class with its constructor and public methods, that looks at its arguments' types first.

    A number is finite or infinite, never NaN, neither a truth value nor complex, and at most `LARGEST` if finite. A
    list where an array belongs is made one, whose numbers are finite; a `Vector` holds at least one.

    Examples
    --------
    >>> @checked
    ... def double(length_m: float) -> float:
    ...     return 2 * length_m
    >>> double("wide")
    Traceback (most recent call last):
    tactometry.errors.InvalidParameter: length_m: found 'wide', expected a number up to 1e+30
    """
    if not isinstance(thing, type):
        return typing.cast(T, _guarded(thing, ""))
    for name, member in list(vars(thing).items()):
        if name == "__init__":
            setattr(thing, name, _guarded(member, f"{thing.__name__}."))
        elif not name.startswith("_") and inspect.isfunction(member):
            setattr(thing, name, _guarded(member, ""))
        elif not name.startswith("_") and isinstance(member, classmethod):
            setattr(thing, name, classmethod(_guarded(member.__func__, "")))
    return thing


def _guarded(function: Callable[..., Any], prefix: str) -> Callable[..., Any]:
    names = list(inspect.signature(function).parameters)

    @functools.cache
    def rules() -> dict[str, Rule]:
        hints = {name: hint for name, hint in function.__annotations__.items() if name != "return"}
        return {name: rule_of(hint) for name, hint in hints.items() if not isinstance(hint, str)}

    @functools.wraps(function)
    def guarded(*args: Any, **kwargs: Any) -> Any:
        rule = rules()
        for name, value in (*zip(names, args, strict=False), *kwargs.items()):
            if name in rule and not rule[name][0](value):
                raise InvalidParameter(_refusal(prefix + name, value, rule[name][1]))
        if not any(isinstance(value, (list, tuple)) for value in (*args, *kwargs.values())):
            return function(*args, **kwargs)
        at = [_arranged(value, function.__annotations__.get(name)) for name, value in zip(names, args, strict=False)]
        named = {name: _arranged(value, function.__annotations__.get(name)) for name, value in kwargs.items()}
        return function(*at, **named)

    return guarded


def _arranged(value: Any, hint: Any) -> Any:
    """A list as the array that the annotation wants."""
    if isinstance(value, (list, tuple)) and (dtype := _dtype(hint)):
        return np.asarray(value, dtype)
    return value


def _dtype(hint: Any) -> type[np.generic] | None:
    """Of an array, or of what may be one."""
    if typing.get_origin(hint) is np.ndarray:
        found: type[np.generic] = typing.get_args(typing.get_args(hint)[1])[0]
        return found
    if hint == ArrayLike or typing.get_origin(hint) not in (Annotated, typing.Union, types.UnionType):
        return None
    return next(filter(None, map(_dtype, typing.get_args(hint))), None)


def _refusal(name: str, value: Any, expected: str) -> str:
    """One sentence; of an array of numbers it names the first that is none."""
    found = _as_array(value)
    if found is None or found.ndim == 0 or found.dtype.kind not in "iufc":
        return f"{name}: found {_shown(value)}, expected {expected}"
    wrong = np.argwhere(~(np.abs(found) <= LARGEST))
    if not len(wrong):
        return f"{name}: found shape {found.shape}, expected {expected}"
    where = tuple(int(i) for i in wrong[0])
    return f"{name}{list(where)}: found {found[where]}, expected a finite number up to 1e+30"


@functools.cache
def rule_of(hint: Any) -> Rule:
    """What a value must be to fit an annotation, as a test and in words."""
    if hint == ArrayLike:
        return _NUMBERS
    if hint in _PLAIN:
        return _PLAIN[hint]
    origin, inner = typing.get_origin(hint), typing.get_args(hint)
    if origin is typing.Literal:
        return lambda value: isinstance(value, str) and value in inner, f"one of {', '.join(map(str, inner))}"
    if origin in (typing.Union, types.UnionType):
        return _either([rule_of(part) for part in inner])
    if origin is Annotated:
        return _shaped(*inner)
    if origin is np.ndarray:
        return _array(hint)
    if origin is tuple and inner[-1] is not Ellipsis:
        return _row([rule_of(part) for part in inner])
    if origin in (Sequence, list, tuple):
        return _each(rule_of(inner[0]))
    if origin is Mapping:
        each, words = rule_of(inner[1])
        return lambda value: isinstance(value, Mapping) and all(map(each, value.values())), f"a mapping to {words}"
    if isinstance(hint, type):
        return _of_class(hint)
    return (callable, "a function") if origin is Callable else (lambda _: True, "anything")


def _of_class(hint: type) -> Rule:
    """A class is looked at once: whether it has what a protocol asks for takes longer than many a call."""
    known: set[type] = set()

    def fits(value: Any) -> bool:
        if type(value) in known:
            return True
        if not isinstance(value, hint):
            return False
        known.add(type(value))
        return True

    return fits, f"a {hint.__name__}"


def _either(rules: Sequence[Rule]) -> Rule:
    return lambda value: any(rule[0](value) for rule in rules), " or ".join(rule[1] for rule in rules)


def _row(rules: Sequence[Rule]) -> Rule:
    def fits(value: Any) -> bool:
        return (
            _is_listed(value) and len(value) == len(rules) and all(r[0](v) for r, v in zip(rules, value, strict=True))
        )

    return fits, f"({', '.join(rule[1] for rule in rules)})"


def _each(rule: Rule) -> Rule:
    return lambda value: _is_listed(value) and all(map(rule[0], value)), f"a list, each of it {rule[1]}"


def _array(hint: Any) -> Rule:
    if issubclass(_dtype(hint) or np.float64, np.complexfloating):
        return (
            lambda value: _is_listed(value) and _are_numbers(value, "iufc"),
            "an array of complex numbers up to 1e+30",
        )
    return lambda value: _is_listed(value) and _are_finite(value), "an array of finite numbers up to 1e+30"


def _shaped(hint: Any, n_dims: int) -> Rule:
    least = 1 if n_dims == 1 else 0
    words = f"{n_dims} dimension{'s' * (n_dims > 1)} of finite numbers up to 1e+30"

    def fits(value: Any) -> bool:
        return bool(_array(hint)[0](value) and np.ndim(value) == n_dims and np.size(value) >= least)

    return fits, f"an array in {words}" + (", at least one" if least else "")


def _is_listed(value: Any) -> bool:
    return (isinstance(value, np.ndarray) and value.ndim > 0) or (
        isinstance(value, Sequence) and not isinstance(value, str)
    )


def _is_number(value: Any) -> bool:
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, float, np.integer, np.floating)):
        return False
    return bool(-LARGEST <= value <= LARGEST) or value in (math.inf, -math.inf)


def _is_complex(value: Any) -> bool:
    return isinstance(value, (complex, np.complexfloating)) and bool(np.abs(value) <= LARGEST)


def _is_whole(value: Any) -> bool:
    return isinstance(value, (int, np.integer)) and _is_number(value)


def _are_numbers(value: Any, kinds: str = "iuf") -> bool:
    found = _as_array(value)
    if found is None or (found.dtype.kind not in kinds and found.size):
        return False
    return _in_range(found) or bool(np.all(_fit(found)))


def _are_finite(value: Any) -> bool:
    found = _as_array(value)
    return found is not None and (found.size == 0 or found.dtype.kind in "iuf") and _in_range(found)


def _in_range(found: NDArray[Any]) -> bool:
    """Without a copy; NaN is not."""
    if found.dtype.kind == "c":
        return _in_range(found.real) and _in_range(found.imag)
    return found.size == 0 or bool(found.min() >= -LARGEST and found.max() <= LARGEST)


def _fit(found: Any) -> NDArray[np.bool_]:
    size: NDArray[np.float64] = np.abs(found)
    return np.asarray((size <= LARGEST) | np.isinf(size))


def _as_array(value: Any) -> NDArray[Any] | None:
    try:
        return np.asarray(value)
    except (ValueError, TypeError):
        return None


def _shown(value: object) -> str:
    return " ".join(reprlib.repr(value).split())


_NUMBERS: Final[Rule] = (_are_numbers, "numbers up to 1e+30")
_PLAIN: Final[Mapping[Any, Rule]] = {
    float: (_is_number, "a number up to 1e+30"),
    complex: (
        lambda value: not isinstance(value, bool) and np.ndim(value) == 0 and _are_numbers(value, "iufc"),
        "a number",
    ),
    int: (_is_whole, "a whole number"),
    bool: (lambda value: isinstance(value, (bool, np.bool_)), "True or False"),
    str: (lambda value: isinstance(value, str), "a text"),
    type(None): (lambda value: value is None, "None"),
    Any: (lambda _: True, "anything"),
}
