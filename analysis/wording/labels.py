"""Names of factors and conditions as a person writes them."""

import re
from collections.abc import Sequence

import numpy as np
import pandas as pd

from .numbers import plain_text

UNITS = {"hz": "Hz", "n": "N", "s": "s", "v": "V", "m": "m", "mm": "mm", "db": "dB", "m_per_s": "m/s"}
DEPENDENT_NAMES = {
    "threshold": "threshold",
    "pse": "point of subjective equality",
    "jnd": "just noticeable difference",
    "setting": "setting by adjustment",
    "exponent": "exponent of magnitude estimates",
}
NAMED = 6
"""So many cells or participants are named one by one."""


def split_unit(name: str) -> tuple[str, str]:
    """A name in words, and the unit that its suffix says; without one an empty text.

    >>> split_unit("frequency_hz"), split_unit("speed_m_per_s"), split_unit("pattern")
    (('frequency', 'Hz'), ('speed', 'm/s'), ('pattern', ''))
    """
    for suffix in sorted(UNITS, key=len, reverse=True):
        if name.endswith(f"_{suffix}"):
            return name[: -len(suffix) - 1].replace("_", " "), UNITS[suffix]
    return name.replace("_", " "), ""


def title_of(name: str) -> str:
    """A factor's name as a person writes it.

    >>> title_of("frequency_hz"), title_of("force_n"), title_of("pattern")
    ('Frequency (Hz)', 'Force (N)', 'Pattern')
    """
    words, unit = split_unit(name)
    return f"{words.capitalize()} ({unit})" if unit else words.capitalize()


def dependent_title(name: str) -> str:
    """What a dependent value is called where it stands alone.

    >>> dependent_title("pse"), dependent_title("threshold")
    ('Point of subjective equality', 'Detection threshold')
    """
    return "Detection threshold" if name == "threshold" else dependent_name(name).capitalize()


def dependent_name(name: str) -> str:
    """A dependent value as a person calls it.

    >>> dependent_name("jnd"), dependent_name("tip_speed")
    ('just noticeable difference', 'tip speed')
    """
    return DEPENDENT_NAMES.get(name, name.replace("_", " "))


def with_unit(name: str, unit: str) -> str:
    """A name with the unit in brackets, if there is one."""
    return f"{name} ({unit})" if unit else name


def in_unit(number: str, unit: str) -> str:
    """A number with its unit, if it has one."""
    return f"{number} {unit}" if unit else number


def level_of(name: str, value: object) -> str:
    """A factor's value with the unit, if its name has one.

    >>> level_of("frequency_hz", 240.0), level_of("pattern", "P0"), level_of("size", 3)
    ('240 Hz', 'P0', '3')
    """
    return in_unit(plain_text(value), split_unit(name)[1])


def value_of(name: str, value: object) -> str:
    """A factor's value that is told from those of other factors, such as ``240 Hz``.

    >>> value_of("frequency_hz", 240.0), value_of("pattern", "P0"), value_of("size", 3)
    ('240 Hz', 'P0', 'size 3')
    """
    words, unit = split_unit(name)
    is_bare = isinstance(value, int | float | np.number) and not unit
    return f"{words} {level_of(name, value)}" if is_bare else level_of(name, value)


def in_words(text: str, factors: Sequence[str]) -> str:
    """A sentence with the names of factors as words, their values with units and a sign between those that interact.

    >>> in_words("force_n * frequency_hz: F(2, 4) = 1.20", ["frequency_hz", "force_n"])
    'force × frequency: F(2, 4) = 1.20'
    >>> in_words("without frequency_hz = 60, force_n = 0.5", ["frequency_hz", "force_n"])
    'without frequency = 60 Hz, force = 0.5 N'
    """
    for name in factors:
        words, unit = split_unit(name)
        whole_name = rf"(?<![\w/.]){re.escape(name)}(?![\w/])"
        if unit:
            text = re.sub(rf"{whole_name} = (-?[\d.]*\d(?:e[+-]?\d+)?)", rf"{name} = \1 {unit}", text)
        text = text if words == name else re.sub(whole_name, words, text)
    return re.sub(r"(?<=\w) \* (?=\w)", " × ", text)


def header_of(column: str, factors: Sequence[str]) -> str:
    """The head of a column of a table for people.

    >>> [header_of(name, ["frequency_hz", "force_n"]) for name in ("frequency_hz", "force_n = 0.5", "n_trials")]
    ['Frequency (Hz)', 'force = 0.5 N', 'n trials']
    """
    return title_of(column) if column in factors else in_words(column, factors).replace("_", " ")


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
