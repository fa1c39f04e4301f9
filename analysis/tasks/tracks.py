"""The levels that procedures went through."""

import numpy as np
import pandas as pd

from ..reading.trials import Trials, used_rows
from .cells import FITTED_TASKS, is_catch, yes

FIXED = ("constant", "constant_stimuli")
"""Procedures whose levels do not depend on the answers."""


def tracks(trials: Trials) -> pd.DataFrame:
    """A row per trial of a procedure whose levels follow the answers, without catch trials: whose, under which
    condition, in which track, of which task and procedure, `step` from 1, the level and whether the answer was yes,
    correct or more. Empty without any."""
    rows = used_rows(trials)
    if "procedure" not in rows.columns:
        return pd.DataFrame()
    rows = rows[rows["task"].isin(FITTED_TASKS) & ~rows["procedure"].isin(FIXED) & ~is_catch(rows)]
    keys = ["participant", *trials.factors, *(name for name in ("session", "track") if name in rows.columns)]
    told = ["task", "procedure", "level", "yes"]
    found = rows.assign(yes=yes(rows))[[*keys, *told]].reset_index(drop=True)
    step = found.groupby(keys, observed=True, dropna=False).cumcount() + 1 if len(found) else np.array([], dtype=int)
    return found.assign(step=step)
