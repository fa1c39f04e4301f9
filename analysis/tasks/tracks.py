"""The levels that procedures went through."""

from collections.abc import Sequence

import pandas as pd

FIXED = ("constant", "constant_stimuli")
"""Procedures whose levels do not depend on the answers."""


def tracks(judged: pd.DataFrame, factors: Sequence[str]) -> pd.DataFrame:
    """A row per judgement on a level that a procedure chose by the answers, without catch trials: whose, under which
    condition, in which track, of which task and procedure, `step` from 1, the level and whether the answer was yes,
    correct or more. Empty where the table names no procedure."""
    if "procedure" not in judged.columns:
        return pd.DataFrame()
    rows = judged[~judged["procedure"].isin(FIXED) & ~judged["is_catch"]]
    within = [name for name in ("session", "track") if name in rows.columns and name not in factors]
    keys = ["participant", *factors, *within]
    steps = rows[[*keys, "task", "procedure", "level", "yes"]].reset_index(drop=True)
    return steps.assign(step=steps.groupby(keys, observed=True, dropna=False).cumcount() + 1)
