"""What the parameters of this package must be, each refused in one sentence."""

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tactometry.errors import InvalidParameter

SMALLEST: Final = 1e-30
"""No quantity above 0 of a screen in SI units is smaller; its reciprocals and powers stay finite."""

_ABOVE_0: Final = f"a finite number above 0, at least {SMALLEST}"


def positive(name: str, value: float) -> None:
    """Refuse `value` unless it is finite and above 0, and not smaller than `SMALLEST`.

    >>> positive("Plate.length_m", -1.0)
    Traceback (most recent call last):
    tactometry.errors.InvalidParameter: Plate.length_m: found -1.0, expected a finite number above 0
    """
    if not (math.isfinite(value) and value > 0):
        raise InvalidParameter(f"{name}: found {value}, expected a finite number above 0")
    if value < SMALLEST:
        raise InvalidParameter(f"{name}: found {value}, expected a number of at least {SMALLEST}")


def not_negative(name: str, value: float) -> None:
    """Refuse `value` unless it is finite and at least 0."""
    if not (math.isfinite(value) and value >= 0):
        raise InvalidParameter(f"{name}: found {value}, expected a finite number, at least 0")


def within(name: str, value: float, low: float, high: float) -> None:
    """Refuse `value` outside of ``[low, high]``, and NaN."""
    if not low <= value <= high:
        raise InvalidParameter(f"{name}: found {value}, expected a number from {low} to {high}")


def share(name: str, value: float) -> None:
    """Refuse `value` unless it lies between 0 and 1, both left out."""
    if not 0 < value < 1:
        raise InvalidParameter(f"{name}: found {value}, expected a number above 0 and below 1")


def finite(name: str, values: ArrayLike) -> None:
    """Refuse a number or an array with NaN or infinity, naming the first."""
    _each(name, values, np.isfinite(values), "a finite number")


def all_positive(name: str, values: ArrayLike) -> None:
    """Refuse a number or an array unless each is finite and above 0."""
    _each(name, values, np.isfinite(values) & (np.asarray(values) >= SMALLEST), _ABOVE_0)


def all_at_least_0(name: str, values: ArrayLike) -> None:
    """Refuse a number or an array unless each is at least 0; infinity is taken."""
    _each(name, values, np.asarray(values) >= 0, "a number, at least 0")


def all_above_0(name: str, values: ArrayLike) -> None:
    """Refuse a number or an array unless each is above 0; infinity is taken."""
    _each(name, values, np.asarray(values) >= SMALLEST, f"a number above 0, at least {SMALLEST}")


def spectral(name: str, values: ArrayLike) -> None:
    """Refuse a number or an array unless each is finite and at least 0, as frequencies and wavenumbers are."""
    _each(name, values, np.isfinite(values) & (np.asarray(values) >= 0), "a finite number, at least 0")


def at_least(name: str, value: int, least: int) -> None:
    """Refuse a whole number below `least`."""
    if value < least:
        raise InvalidParameter(f"{name}: found {value}, expected at least {least}")


def at_most(name: str, value: float, most: float) -> None:
    """Refuse a number above `most`, and NaN."""
    if not value <= most:
        raise InvalidParameter(f"{name}: found {value:.6g}, expected at most {most:.6g}")


def shaped(name: str, values: ArrayLike, shape: tuple[int | None, ...]) -> None:
    """Refuse an array of another shape; None stands for any length.

    >>> shaped("field_m", [1.0, 2.0], (3,))
    Traceback (most recent call last):
    tactometry.errors.InvalidParameter: field_m: found shape (2,), expected (3)
    """
    found = np.shape(values)
    if len(found) != len(shape) or any(n not in (m, None) for m, n in zip(found, shape, strict=True)):
        words = ", ".join("any" if n is None else str(n) for n in shape)
        raise InvalidParameter(f"{name}: found shape {found}, expected ({words})")


def ascending(name: str, values: ArrayLike) -> None:
    """Refuse a list unless it is finite, has two or more numbers, and each is above the one before."""
    found = np.asarray(values, float)
    finite(name, found)
    if found.ndim != 1 or len(found) < 2 or not (np.diff(found) > 0).all():
        raise InvalidParameter(
            f"{name}: found shape {found.shape} not ascending, expected two or more ascending numbers"
        )


def _each(name: str, values: ArrayLike, good: NDArray[np.bool_], expected: str) -> None:
    if not np.all(good):
        found, where = np.asarray(values), tuple(int(i) for i in np.argwhere(~np.asarray(good))[0])
        raise InvalidParameter(f"{name}{list(where) or ''}: found {found[where]}, expected {expected}")


def some(name: str, values: Sequence[object]) -> None:
    """Refuse an empty sequence."""
    if len(values) == 0:
        raise InvalidParameter(f"{name}: found none, expected at least one")


def choice(name: str, value: str, allowed: Sequence[str]) -> None:
    """Refuse a word that is not in `allowed`."""
    if value not in allowed:
        raise InvalidParameter(f"{name}: found {value!r}, expected one of {', '.join(allowed)}")
