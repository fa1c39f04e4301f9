"""What the parameters of this package must be, each refused in one sentence."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tactometry.errors import InvalidParameter


def positive(name: str, value: float) -> None:
    """Refuse `value` unless it is finite and above 0.

    >>> positive("Plate.length_m", -1.0)
    Traceback (most recent call last):
    tactometry.errors.InvalidParameter: Plate.length_m: found -1.0, expected a finite number above 0
    """
    if not (math.isfinite(value) and value > 0):
        raise InvalidParameter(f"{name}: found {value}, expected a finite number above 0")


def not_negative(name: str, value: float) -> None:
    """Refuse `value` unless it is finite and at least 0."""
    if not (math.isfinite(value) and value >= 0):
        raise InvalidParameter(f"{name}: found {value}, expected a finite number, at least 0")


def within(name: str, value: float, low: float, high: float) -> None:
    """Refuse `value` outside of ``[low, high]``, and NaN."""
    if not low <= value <= high:
        raise InvalidParameter(f"{name}: found {value}, expected a number from {low} to {high}")


def finite(name: str, values: NDArray[np.float64]) -> None:
    """Refuse an array with NaN or infinity, naming the first."""
    if not np.isfinite(values).all():
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(values))[0])
        raise InvalidParameter(f"{name}{list(where)}: found {values[where]}, expected a finite number")


def some(name: str, values: Sequence[object]) -> None:
    """Refuse an empty sequence."""
    if len(values) == 0:
        raise InvalidParameter(f"{name}: found none, expected at least one")


def choice(name: str, value: str, allowed: Sequence[str]) -> None:
    """Refuse a word that is not in `allowed`."""
    if value not in allowed:
        raise InvalidParameter(f"{name}: found {value!r}, expected one of {', '.join(allowed)}")
