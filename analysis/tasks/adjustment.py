"""The method of adjustment: the mean of the levels that a participant set, and how much they vary.

Gescheider, Psychophysics: The Fundamentals, 3rd ed. (1997), chapter 3.
"""

import numpy as np
import pandas as pd

from ..means import mean_row
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
    mean = mean_row(np.asarray(settings, dtype=np.float64), interval)
    named = {name.replace("mean", DEPENDENT): value for name, value in mean.items()}
    return {"task": TASK, **named, "n_settings": len(settings)}
