"""Tables of values of which some are known to lie below a bound."""

import numpy as np
import pandas as pd

GIVEN = {"dependent": "y", "low": "low", "high": "high", "subject": "subject"}


def open_ended(table: pd.DataFrame) -> pd.DataFrame:
    return table.assign(low=np.nan, high=np.nan)


def cut(table: pd.DataFrame, at: float) -> pd.DataFrame:
    """Values below `at` are known to lie below it, no more."""
    below = table["y"] < at
    return table.assign(y=table["y"].where(~below), low=np.nan, high=np.where(below, at, np.nan))
