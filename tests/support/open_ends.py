"""Tables with values that are known only to lie below a bound."""

import numpy as np
import pandas as pd

GIVEN = {"dependent": "y", "low": "low", "high": "high", "subject": "subject"}


def open_ended(table: pd.DataFrame) -> pd.DataFrame:
    return table.assign(low=np.nan, high=np.nan)


def cut(table: pd.DataFrame, at: float) -> pd.DataFrame:
    """Mark values below `at` as known only to lie below it."""
    below = table["y"] < at
    return table.assign(y=table["y"].where(~below), low=np.nan, high=np.where(below, at, np.nan))
