"""The method of adjustment: the mean of the levels that a participant set, and how much they vary.

Gescheider, Psychophysics: The Fundamentals, 3rd ed. (1997), chapter 3.
"""

import numpy as np
import pandas as pd

from ..outcomes.group_means import mean_with_interval
from ..reading.trials import Trials, parsed, used_rows

TASK = "adjustment"
DEPENDENT = "setting"


def adjustment_table(trials: Trials, interval: float = 0.95) -> pd.DataFrame:
    """A row per participant and condition: the mean `setting` with its t-interval over the settings, their standard
    deviation `sd` and number; empty without adjustments."""
    rows = used_rows(trials)
    rows = rows[rows["task"] == TASK]
    if rows.empty:
        return pd.DataFrame()
    keys = ["participant", *trials.factors]
    grouped = rows.assign(setting=parsed(rows["response"])).groupby(keys, sort=True, observed=True)["setting"]
    return pd.DataFrame([dict(zip(keys, key, strict=True)) | _row(part, interval) for key, part in grouped])


def _row(settings: "pd.Series[float]", interval: float) -> dict[str, object]:
    found: dict[str, object] = {"task": TASK, "mean": None, "mean_low": None, "mean_high": None, "sd": None}
    found |= mean_with_interval(np.asarray(settings, dtype=np.float64), interval)
    return {name.replace("mean", DEPENDENT): value for name, value in found.items()} | {"n_settings": len(settings)}
