"""Numbers that must be finite, above 0 or not below it; words that must be of a list."""

import math
from collections.abc import Collection

from tactometry.errors import InvalidParameter, nearest


def above_zero(owner: str, **values: float) -> None:
    """Refuse what is not finite and above 0.

    Raises
    ------
    InvalidParameter
        If a value is not; the sentence names `owner` and the value's name.

    >>> above_zero("ForceGate", target_n=1.0, tolerance=0.2)
    """
    for name, value in values.items():
        if not 0 < value < math.inf:
            raise InvalidParameter(f"{owner}.{name}: found {value}, expected a finite number above 0")


def at_least_zero(owner: str, **values: float) -> None:
    """Refuse what is not finite and at least 0.

    Raises
    ------
    InvalidParameter
        As `above_zero`.

    >>> at_least_zero("ForceGate", hold_s=0.0)
    """
    for name, value in values.items():
        if not 0 <= value < math.inf:
            raise InvalidParameter(f"{owner}.{name}: found {value}, expected a finite number, at least 0")


def one_of(where: str, found: str, expected: Collection[str]) -> None:
    """Refuse a word that is none of those expected.

    Raises
    ------
    InvalidParameter
        If it is none; the sentence opens with `where`.

    >>> one_of("QuestPlus.aim", "threshold", ("parameters", "threshold"))
    """
    if found not in expected:
        raise InvalidParameter(
            f"{where}: found {found!r}, expected one of {', '.join(expected)}{nearest(str(found), expected)}"
        )
