"""Smallest and largest magnitudes by the unit at the end of a name.

A nonzero number outside this range is probably in the wrong unit. Squares and quotients of numbers inside the range can
be represented as a double.
"""

from collections.abc import Mapping
from functools import lru_cache
from math import isfinite
from numbers import Real
from typing import Any, TypeGuard

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
