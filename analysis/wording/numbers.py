"""Numbers as text: three significant digits at least, and a value in as many as its interval needs."""

import math
from typing import Any

import numpy as np
import pandas as pd

DIGITS = 3
SMALLEST, LARGEST = 1e-3, 1e6
"""Numbers beyond are told with an exponent."""


def decimals_of(x: float) -> int:
    """The decimal places that show three significant digits; one at least.

    >>> decimals_of(0.213), decimals_of(-4.8), decimals_of(120.0), decimals_of(0.0)
    (3, 2, 1, 1)
    """
    return max(1, DIGITS - 1 - math.floor(math.log10(abs(x)))) if x else 1


def number_text(x: float) -> str:
    """
    >>> number_text(-4.8125), number_text(0.21349), number_text(120.34), number_text(2.5e-6), number_text(0.0)
    ('-4.81', '0.213', '120.3', '2.5e-06', '0.0')
    """
    return f"{x:.{decimals_of(x)}f}" if x == 0 or SMALLEST <= abs(x) < LARGEST else f"{x:.{DIGITS}g}"


def interval_texts(value: float, low: float, high: float) -> tuple[str, str, str]:
    """A value and the ends of its interval, in the same decimal places: those that show three significant digits of the
    value, or of the larger end where the interval holds 0, and at least so many that the ends differ.

    >>> interval_texts(1.25, 0.9, 1.61), interval_texts(0.2134, 0.1478, 0.2623), interval_texts(0.02, -1.5, 1.4)
    (('1.25', '0.90', '1.61'), ('0.213', '0.148', '0.262'), ('0.02', '-1.50', '1.40'))
    >>> interval_texts(1e6 + 0.5, 1e6 + 0.4, 1e6 + 0.7), interval_texts(2.5e-6, 1.25e-6, 4e-6)
    (('1000000.50', '1000000.40', '1000000.70'), ('2.5e-06', '1.25e-06', '4e-06'))
    """
    size = max(abs(low), abs(high)) if low <= 0 <= high else abs(value)
    decimals = decimals_of(size)
    apart = 1 - math.floor(math.log10(high - low)) if high > low else 0
    if (size >= LARGEST and apart <= 0) or 0 < size < SMALLEST:
        return number_text(value), number_text(low), number_text(high)
    return tuple(f"{x:.{max(decimals, apart)}f}" for x in (value, low, high))  # type: ignore[return-value]


def interval_text(value: Any, low: Any = None, high: Any = None) -> str:
    """The value, with its interval if there is one.

    >>> interval_text(1.25, 0.9, 1.61), interval_text(1.25), interval_text(0.93, 0.87, 0.99)
    ('1.25 [0.90, 1.61]', '1.25', '0.930 [0.870, 0.990]')
    """
    if pd.isna(low) or pd.isna(high):
        return number_text(float(value))
    texts = interval_texts(float(value), float(low), float(high))
    return f"{texts[0]} [{texts[1]}, {texts[2]}]"


def plain_text(value: object) -> str:
    """A number as it was stated, anything else as its text.

    >>> plain_text(240.0), plain_text(0.5), plain_text("P0")
    ('240', '0.5', 'P0')
    """
    return f"{value:g}" if isinstance(value, int | float | np.number) else str(value)


def cell_text(value: Any) -> str:
    """A cell of a table for people: nothing where nothing is known.

    >>> cell_text(240.0), cell_text(12345.0), cell_text(0.21349), cell_text(7), cell_text(None), cell_text(float("nan"))
    ('240', '12345', '0.213', '7', '', '')
    """
    if value is None or value is pd.NA or (isinstance(value, float) and math.isnan(value)):
        return ""
    if isinstance(value, float):
        return str(int(value)) if value.is_integer() and abs(value) < LARGEST else number_text(value)
    return str(value)


def p_text(p: float) -> str:
    """
    >>> p_text(0.03141), p_text(1e-9), p_text(0.9999)
    ('p = .031', 'p < .001', 'p > .999')
    """
    if p < 0.001:
        return "p < .001"
    return "p > .999" if p > 0.9995 else f"p = {p:.3f}".replace("0.", ".", 1)


def share_text(x: float) -> str:
    """A number that cannot pass 1, without its leading zero.

    >>> share_text(0.8449), share_text(-0.043), share_text(1.0)
    ('.845', '-.043', '1.000')
    """
    return f"{x:.3f}".replace("0.", ".", 1) if abs(x) < 1 else f"{x:.3f}"


def percent_text(share: float) -> str:
    """
    >>> percent_text(0.954)
    '95 %'
    """
    return f"{100 * share:.0f} %"
