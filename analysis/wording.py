"""Formatting of numbers, names, conditions and tables as text."""

import math
import re
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

DIGITS = 3
SMALLEST, LARGEST = 1e-3, 1e6
"""Numbers outside this range are written with an exponent."""


def decimals_of(x: float) -> int:
    """Return the number of decimals for three significant digits, at least 1.

    >>> decimals_of(0.213), decimals_of(-4.8), decimals_of(120.0), decimals_of(0.0)
    (3, 2, 1, 1)
    """
    return max(1, DIGITS - 1 - math.floor(math.log10(abs(x)))) if x else 1


def number_text(x: float) -> str:
    """Format a number with three significant digits.

    >>> number_text(-4.8125), number_text(0.21349), number_text(120.34), number_text(2.5e-6), number_text(0.0)
    ('-4.81', '0.213', '120.3', '2.5e-06', '0.0')
    """
    return f"{x:.{decimals_of(x)}f}" if x == 0 or SMALLEST <= abs(x) < LARGEST else f"{x:.{DIGITS}g}"


def interval_texts(value: float, low: float, high: float) -> tuple[str, str, str]:
    """Format a value and its interval with equal numbers of decimals.

    Decimals show three significant digits of the value, or of the larger end if the interval contains 0, and at least
    as many as needed to distinguish the ends.

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


def interval_text(value: Any, low: Any = None, high: Any = None, decimals: int | None = None) -> str:
    """Format a value with its interval, optionally with fixed `decimals`.

    >>> interval_text(1.25, 0.9, 1.61), interval_text(1.25), interval_text(0.93, 0.87, 0.99)
    ('1.25 [0.90, 1.61]', '1.25', '0.930 [0.870, 0.990]')
    >>> interval_text(0.93, 0.87, 0.99, decimals=2), interval_text(0.93, decimals=2)
    ('0.93 [0.87, 0.99]', '0.93')
    """
    is_alone = pd.isna(low) or pd.isna(high)
    if decimals is not None:
        return f"{value:.{decimals}f}" + ("" if is_alone else f" [{low:.{decimals}f}, {high:.{decimals}f}]")
    if is_alone:
        return number_text(float(value))
    texts = interval_texts(float(value), float(low), float(high))
    return f"{texts[0]} [{texts[1]}, {texts[2]}]"


def ends_text(low: Any, high: Any) -> str:
    """Format an interval that may be open at one end.

    >>> ends_text(12.0, 25.5), ends_text(None, 25.5), ends_text(12.0, math.nan)
    ('[12.0, 25.5]', 'at most 25.5', 'at least 12.0')
    """
    if pd.isna(low) or pd.isna(high):
        return f"at most {number_text(high)}" if pd.isna(low) else f"at least {number_text(low)}"
    return f"[{number_text(low)}, {number_text(high)}]"


def plain_text(value: object) -> str:
    """Format a number without trailing zeros, and any other value as text.

    >>> plain_text(240.0), plain_text(0.5), plain_text("P0")
    ('240', '0.5', 'P0')
    """
    return f"{value:g}" if isinstance(value, int | float | np.number) else str(value)


def cell_text(value: Any) -> str:
    """Format a table cell; missing values become "".

    >>> cell_text(240.0), cell_text(12345.0), cell_text(0.21349), cell_text(7), cell_text(None), cell_text(float("nan"))
    ('240', '12345', '0.213', '7', '', '')
    """
    if value is None or value is pd.NA or (isinstance(value, float) and math.isnan(value)):
        return ""
    if isinstance(value, float):
        return str(int(value)) if value.is_integer() and abs(value) < LARGEST else number_text(value)
    return str(value)


def p_text(p: float) -> str:
    """Format a p value.

    >>> p_text(0.03141), p_text(1e-9), p_text(0.9999)
    ('p = .031', 'p < .001', 'p > .999')
    """
    if p < 0.001:
        return "p < .001"
    return "p > .999" if p > 0.9995 else f"p = {p:.3f}".replace("0.", ".", 1)


def share_text(x: float) -> str:
    """Format a number of at most 1 without its leading zero.

    >>> share_text(0.8449), share_text(-0.043), share_text(1.0)
    ('.845', '-.043', '1.000')
    """
    return f"{x:.3f}".replace("0.", ".", 1) if abs(x) < 1 else f"{x:.3f}"


def percent_text(share: float) -> str:
    """Format a share as a percentage.

    >>> percent_text(0.954)
    '95 %'
    """
    return f"{100 * share:.0f} %"


UNITS = {"hz": "Hz", "n": "N", "s": "s", "v": "V", "m": "m", "mm": "mm", "db": "dB", "m_per_s": "m/s"}
DEPENDENT_NAMES = {
    "threshold": "threshold",
    "pse": "point of subjective equality",
    "jnd": "just noticeable difference",
    "setting": "setting by adjustment",
    "exponent": "exponent of magnitude estimates",
}
NAMED = 6
"""Largest number of cells or participants listed by name."""


def split_unit(name: str) -> tuple[str, str]:
    """Split a column name into words and the unit of its suffix ("" if none).

    >>> split_unit("frequency_hz"), split_unit("speed_m_per_s"), split_unit("pattern")
    (('frequency', 'Hz'), ('speed', 'm/s'), ('pattern', ''))
    """
    for suffix in sorted(UNITS, key=len, reverse=True):
        if name.endswith(f"_{suffix}"):
            return name[: -len(suffix) - 1].replace("_", " "), UNITS[suffix]
    return name.replace("_", " "), ""


def title_of(name: str) -> str:
    """Return the name of a factor as a heading.

    >>> title_of("frequency_hz"), title_of("force_n"), title_of("pattern")
    ('Frequency (Hz)', 'Force (N)', 'Pattern')
    """
    words, unit = split_unit(name)
    return f"{words.capitalize()} ({unit})" if unit else words.capitalize()


def dependent_title(name: str) -> str:
    """Return the name of a dependent variable as a heading.

    >>> dependent_title("pse"), dependent_title("threshold")
    ('Point of subjective equality', 'Detection threshold')
    """
    return "Detection threshold" if name == "threshold" else dependent_name(name).capitalize()


def dependent_name(name: str) -> str:
    """Return the name of a dependent variable in words.

    >>> dependent_name("jnd"), dependent_name("tip_speed")
    ('just noticeable difference', 'tip speed')
    """
    return DEPENDENT_NAMES.get(name, name.replace("_", " "))


def with_unit(name: str, unit: str) -> str:
    return f"{name} ({unit})" if unit else name


def in_unit(number: str, unit: str) -> str:
    return f"{number} {unit}" if unit else number


def level_of(name: str, value: object) -> str:
    """Format a level of a factor with the unit in the factor's name, if any.

    >>> level_of("frequency_hz", 240.0), level_of("pattern", "P0"), level_of("size", 3)
    ('240 Hz', 'P0', '3')
    """
    return in_unit(plain_text(value), split_unit(name)[1])


def value_of(name: str, value: object) -> str:
    """Format a level with its unit, or else after the factor's name.

    >>> value_of("frequency_hz", 240.0), value_of("pattern", "P0"), value_of("size", 3)
    ('240 Hz', 'P0', 'size 3')
    """
    words, unit = split_unit(name)
    is_bare = isinstance(value, int | float | np.number) and not unit
    return f"{words} {level_of(name, value)}" if is_bare else level_of(name, value)


def in_words(text: str, factors: Sequence[str]) -> str:
    """Replace factor names by words, add units, and write * as ×.

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
    """Return the heading of a column.

    >>> [header_of(name, ["frequency_hz", "force_n"]) for name in ("frequency_hz", "force_n = 0.5", "n_trials")]
    ['Frequency (Hz)', 'force = 0.5 N', 'n trials']
    """
    return title_of(column) if column in factors else in_words(column, factors).replace("_", " ")


def condition_name(factors: Sequence[str], condition: Sequence[object]) -> str:
    return ", ".join(value_of(name, value) for name, value in zip(factors, condition, strict=True)) or "all"


def first_named(names: Sequence[str], most: int = NAMED) -> str:
    """Join the first names and the number of further names.

    >>> first_named(["P1", "P2"]), first_named(["P1", "P2", "P3"], most=2)
    ('P1, P2', 'P1, P2 and 1 more')
    """
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return f"{', '.join(names[:most])}{more}"


def named_cells(table: pd.DataFrame, factors: Sequence[str]) -> str:
    """Join the first cells by name, and the number of further cells."""
    rows = table.head(NAMED).to_dict("records")
    names = [f"{row['participant']} {condition_name(factors, [row[name] for name in factors])}" for row in rows]
    more = len(table) - len(names)
    return "; ".join(names) + (f"; and {more} more" if more else "")


REVERSALS, POSTERIOR_MEAN = "mean of an even number of reversals, without the first two or three", "posterior mean"


class ProcedureWords(NamedTuple):
    """Name of a procedure with its article, and of its estimate, if any."""

    phrase: str
    estimate: str = ""


PROCEDURES = {
    "constant_stimuli": ProcedureWords("the method of constant stimuli"),
    "staircase": ProcedureWords("a staircase", REVERSALS),
    "weighted_staircase": ProcedureWords("a weighted staircase", REVERSALS),
    "method_of_limits": ProcedureWords("the method of limits", "mean of the transitions"),
    "quest": ProcedureWords("QUEST", POSTERIOR_MEAN),
    "quest_plus": ProcedureWords("QUEST+", POSTERIOR_MEAN),
    "psi": ProcedureWords("the psi method", POSTERIOR_MEAN),
}


def procedure_phrase(kind: str) -> str:
    """Return the name of a procedure with its article.

    >>> procedure_phrase("staircase"), procedure_phrase("stochastic_approximation")
    ('a staircase', 'stochastic approximation')
    """
    return PROCEDURES[kind].phrase if kind in PROCEDURES else kind.replace("_", " ")


def procedure_name(kind: str) -> str:
    """Return the name of a procedure without its article.

    >>> procedure_name("staircase"), procedure_name("their_staircase")
    ('staircase', 'their_staircase')
    """
    return procedure_phrase(kind).removeprefix("a ").removeprefix("the ") if kind in PROCEDURES else kind


MOST_COLUMNS = 8
"""Largest number of columns of conditions in a table."""


def cross_table(group: pd.DataFrame, factors: Sequence[str]) -> pd.DataFrame:
    """Arrange texts with the factor with the most levels in rows.

    If this is too wide, only one factor (numeric if possible) is in columns.
    """
    if len(factors) < 2:
        return group[[*factors, "text"]].rename(columns={"text": "mean"})
    down = max(factors, key=lambda name: group[name].nunique())
    across = [name for name in factors if name != down]
    if math.prod(group[name].nunique() for name in across) > MOST_COLUMNS:
        numeric = [name for name in factors if pd.api.types.is_numeric_dtype(group[name])]
        across = [max(numeric or [down], key=lambda name: group[name].nunique())]
    others = [name for name in factors if name not in across]
    table = group.pivot(index=others, columns=across, values="text")
    columns = []
    keys: list[Any] = list(table.columns)
    for key in keys:
        levels = zip(across, key if isinstance(key, tuple) else (key,), strict=True)
        columns.append(", ".join(f"{name} = {plain_text(level)}" for name, level in levels))
    return table.set_axis(columns, axis="columns").reset_index()
