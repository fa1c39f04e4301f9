"""Plausible upper bounds of limits in files, and limits switched off."""

from collections.abc import Mapping
from math import inf
from typing import Final

from ..errors import InvalidParameter

WORD: Final = "unlimited"

HIGHEST: Final[Mapping[str, float]] = {
    "voltage_peak_v": 5e3,
    "duration_s": 600.0,
    "current_peak_a": 10.0,
    "charge_peak_c": 0.01,
    "displacement_peak_m": 1e-3,
    "session_s": 86_400.0,
    "force_peak_n": 50.0,
    "charge_session_c": 1.0,
    "stop_within_s": 1.0,
    "max_age_days": 3650,
}
"""Plausible upper bounds by key. A larger number would not limit anything (unverified defaults)."""


class Unlimited(float):
    """Limit that is switched off: infinity, stored in files as "unlimited"."""

    def __new__(cls) -> "Unlimited":
        return super().__new__(cls, inf)

    def __reduce__(self) -> tuple[type["Unlimited"], tuple[()]]:
        return Unlimited, ()

    def __str__(self) -> str:
        return WORD

    def __repr__(self) -> str:
        return f"'{WORD}'"


UNLIMITED: Final = Unlimited()


def check_highest(path: str, value: float) -> None:
    """Refuse a limit in a file above its plausible upper bound.

    >>> check_highest("limits.force_peak_n", 1e9)
    Traceback (most recent call last):
    tactometry.errors.InvalidParameter: limits.force_peak_n: found 1e+09, expected at most 50, or "unlimited"
    """
    highest = HIGHEST[path.rpartition(".")[2]]
    if value > highest:
        found = value if isinstance(value, int) else f"{value:.6g}"
        raise InvalidParameter(f'{path}: found {found}, expected at most {highest:g}, or "{WORD}"')


def warning_of(key: str) -> str:
    """Return the warning that a limit is switched off.

    >>> warning_of("limits.force_peak_n")
    'limits.force_peak_n = "unlimited": this limit is switched off'
    """
    return f'{key} = "{WORD}": this limit is switched off'
