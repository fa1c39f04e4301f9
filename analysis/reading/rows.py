"""What the rows of a trials table say of their trials."""

import numpy as np
import pandas as pd

from .cell_numbers import numbers_of


def holds(rows: pd.DataFrame, name: str, value: object) -> "pd.Series[bool]":
    """Which rows hold a value in a column that a table may lack."""
    return rows[name] == value if name in rows.columns else pd.Series(False, index=rows.index)


def is_catch(rows: pd.DataFrame) -> "pd.Series[bool]":
    """Which trials were catch trials."""
    return holds(rows, "catch", 1)


def delivered_level(rows: pd.DataFrame) -> "pd.Series[float]":
    """The level that was delivered where that is known, else the one that was asked for."""
    if "level_delivered" not in rows.columns:
        return rows["level"]
    return rows["level_delivered"].fillna(rows["level"])


def correctness(rows: pd.DataFrame) -> "pd.Series[float]":
    """1 where the answer was right, 0 where it was wrong; NaN where the row says neither that nor what was right."""
    stated = rows["correct"] if "correct" in rows.columns else pd.Series(np.nan, index=rows.index)
    if "target" not in rows.columns:
        return stated
    is_right = numbers_of(rows["response"]) == rows["target"]
    return stated.fillna(is_right.astype(float).where(rows["target"].notna()))
