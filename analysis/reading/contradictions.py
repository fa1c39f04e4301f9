"""Warnings about contradictory columns and impossible values."""

from collections.abc import Iterator

import numpy as np
import pandas as pd
from scipy.special import bdtr

from tactometry.errors import count_of
from tactometry.trials.tasks import tasks_with_level

from .level_scale import is_logarithm
from .rows import correctness, first_place, numbers_of

CHOSEN = ("forced_choice", "localisation")
"""Tasks in which the correct response equals `target`."""
OF_SIGN = ("comparison", "adjustment", "same_different")
"""Tasks whose levels may be signed differences in any unit."""

FEWEST_CHOICES = 50
"""Number of forced choices after which each alternative should have appeared at least once."""
LONG_S = 60.0
"""Median latency above which the values are most likely in milliseconds (unverified default)."""
BELOW_CHANCE_P = 1e-4
"""Probability of so few correct answers by guessing, below which a warning is issued (unverified default)."""


def contradictions(rows: pd.DataFrame) -> Iterator[str]:
    """Warn about contradictory columns, with the number of rows."""
    checks = (
        (_wrong_correctness(rows), "a value of 'correct' that contradicts 'response' and 'target'; 'correct' was used"),
        (_beyond_alternatives(rows), "a response or target above 'n_alternatives'; the stated number was used"),
        (_signed_amplitudes(rows), "a negative level in a non-logarithmic unit; check 'level' and 'level_unit'"),
        (_unused_alternatives(rows), "an 'n_alternatives' above every response and target; the stated number was used"),
        (_stated_guessing(rows), "an 'n_alternatives', which the task yes_no does not use; check 'task'"),
        (_long_latencies(rows), "a 'latency_s' above a minute; if these are milliseconds, state them in [units]"),
        (_below_chance(rows), "answers of participants who score below chance; check 'correct'"),
        (_column(rows, "latency_s") < 0, "a negative 'latency_s' (an answer before the question)"),
    )
    for mask, what in checks:
        if mask.any():
            verb = "has" if mask.sum() == 1 else "have"
            yield f"{count_of(int(mask.sum()), 'row')} {verb} {what} {first_place(rows[mask])}"


def _column(rows: pd.DataFrame, name: str) -> "pd.Series[float]":
    return rows[name] if name in rows.columns else pd.Series(np.nan, index=rows.index)


def _wrong_correctness(rows: pd.DataFrame) -> "pd.Series[bool]":
    response, target, stated = _chosen(rows), _column(rows, "target"), _column(rows, "correct")
    known = response.notna() & target.notna() & stated.notna()
    return known & ((response == target) != (stated == 1))


def _beyond_alternatives(rows: pd.DataFrame) -> "pd.Series[bool]":
    stated, of_choices = _column(rows, "n_alternatives"), rows["task"].isin(CHOSEN)
    return of_choices & ((_chosen(rows) > stated) | (_column(rows, "target") > stated))


def _unused_alternatives(rows: pd.DataFrame) -> "pd.Series[bool]":
    """Find rows with an alternative never chosen and never the target.

    Only tables in which the target varies are examined.
    """
    stated, is_choice = _column(rows, "n_alternatives"), rows["task"] == "forced_choice"
    largest = pd.concat([_chosen(rows), _column(rows, "target")], axis=1).max(axis=1).where(is_choice)
    groups = largest.groupby(stated)
    varies = _column(rows, "target").groupby(stated).transform("nunique") > 1
    return varies & (groups.transform("count") >= FEWEST_CHOICES) & (groups.transform("max") < stated)


def _stated_guessing(rows: pd.DataFrame) -> "pd.Series[bool]":
    return (rows["task"] == "yes_no") & _column(rows, "n_alternatives").notna()


def _long_latencies(rows: pd.DataFrame) -> "pd.Series[bool]":
    """Find latencies above `LONG_S`, if the median is above it."""
    is_long = _column(rows, "latency_s") > LONG_S
    return is_long & (_column(rows, "latency_s").median() > LONG_S)


def _below_chance(rows: pd.DataFrame) -> "pd.Series[bool]":
    """Find forced choices of participants who score below chance."""
    known = rows[(rows["task"] == "forced_choice") & (rows["response"] != "")]
    right, n = correctness(known), _column(known, "n_alternatives").fillna(_chosen(known).max())
    by_code = pd.DataFrame({"right": right, "chance": 1 / n}).dropna().groupby(known["participant"])
    result = by_code.agg(n=("right", "size"), right=("right", "sum"), chance=("chance", "mean"))
    p = bdtr(result["right"], result["n"], result["chance"])
    return rows["participant"].isin(result.index[p < BELOW_CHANCE_P]) & (rows["task"] == "forced_choice")


def _chosen(rows: pd.DataFrame) -> "pd.Series[float]":
    """Return the chosen interval or alternative, NaN in other tasks."""
    of_choices = rows["task"].isin(CHOSEN)
    chosen = pd.Series(np.nan, index=rows.index)
    chosen[of_choices] = numbers_of(rows.loc[of_choices, "response"])
    return chosen


def _signed_amplitudes(rows: pd.DataFrame) -> "pd.Series[bool]":
    if "level_unit" not in rows.columns:
        return pd.Series(False, index=rows.index)
    units = [unit for unit in rows["level_unit"].unique() if unit and not is_logarithm(unit)]
    has_unit = rows["level_unit"].isin(units)
    is_amplitude = rows["task"].isin(tasks_with_level("curve", "ratio")) & ~rows["task"].isin(OF_SIGN)
    return is_amplitude & has_unit & (rows["level"] < 0)
