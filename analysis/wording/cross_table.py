"""A group table across and down, as text."""

import math
from collections.abc import Sequence

import pandas as pd

from .numbers import plain_text

MOST_COLUMNS = 8
"""Conditions across a table of text."""


def cross_table(group: pd.DataFrame, factors: Sequence[str]) -> pd.DataFrame:
    """The thesis's form: the factor with most levels (frequency) down, the others (force) across; cells as text. Where
    that would be too wide, one factor, of numbers if there is one, runs across and the others down."""
    if len(factors) < 2:
        return group[[*factors, "text"]].rename(columns={"text": "mean"})
    down = max(factors, key=lambda name: group[name].nunique())
    across = [name for name in factors if name != down]
    if math.prod(group[name].nunique() for name in across) > MOST_COLUMNS:
        numeric = [name for name in factors if pd.api.types.is_numeric_dtype(group[name])]
        across = [max(numeric or [down], key=lambda name: group[name].nunique())]
    others = [name for name in factors if name not in across]
    table = group.pivot(index=others, columns=across, values="text")
    table.columns = [_column_name(across, key) for key in table.columns]
    return table.reset_index()


def _column_name(across: Sequence[str], key: object) -> str:
    values = key if isinstance(key, tuple) else (key,)
    return ", ".join(f"{name} = {plain_text(value)}" for name, value in zip(across, values, strict=True))
