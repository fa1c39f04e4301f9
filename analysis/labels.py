"""Names of factors and conditions as a person writes them."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

UNITS = {"hz": "Hz", "n": "N", "s": "s", "v": "V", "m": "m", "mm": "mm", "db": "dB", "m_per_s": "m/s"}
NAMED = 6
"""So many cells are named one by one."""


def title_of(name: str) -> str:
    """A factor's name as a person writes it.

    >>> title_of("frequency_hz"), title_of("force_n"), title_of("pattern")
    ('Frequency (Hz)', 'Force (N)', 'Pattern')
    """
    for suffix in sorted(UNITS, key=len, reverse=True):
        if name.endswith(f"_{suffix}"):
            return f"{name[: -len(suffix) - 1].replace('_', ' ').capitalize()} ({UNITS[suffix]})"
    return name.replace("_", " ").capitalize()


def value_of(name: str, value: object) -> str:
    """A factor's value with its unit, such as ``240 Hz``.

    >>> value_of("frequency_hz", 240.0), value_of("pattern", "P0")
    ('240 Hz', 'P0')
    """
    text = f"{value:g}" if isinstance(value, int | float | np.number) else str(value)
    for suffix in sorted(UNITS, key=len, reverse=True):
        if name.endswith(f"_{suffix}"):
            return f"{text} {UNITS[suffix]}"
    return text if not isinstance(value, int | float | np.number) else f"{name.replace('_', ' ')} {text}"


def percent_text(share: float) -> str:
    """
    >>> percent_text(0.954)
    '95 %'
    """
    return f"{100 * share:.0f} %"


def condition_name(factors: Sequence[str], condition: Sequence[object]) -> str:
    return ", ".join(value_of(name, value) for name, value in zip(factors, condition, strict=True)) or "all"


def named_cells(table: pd.DataFrame, factors: Sequence[str]) -> str:
    """Participants with their conditions, the first of them by name."""
    names = [
        f"{row['participant']} {condition_name(factors, [row[name] for name in factors])}"
        for _, row in table.head(NAMED).iterrows()
    ]
    more = len(table) - len(names)
    return "; ".join(names) + (f"; and {more} more" if more else "")
