"""Tables of choices for people: levels and compared items with their units, d' under its own sign."""

import pandas as pd

from tactometry.trials.columns import stated_factors

from ..reading.trials import Trials, parsed
from ..tasks.preference import ORDER
from ..wording.labels import level_of

SENSITIVITIES = {"d_prime_differencing": "d′ differencing", "d_prime_independent": "d′ independent"}
COUNTS = {"hits": ("n_hits", "n_different"), "false alarms": ("n_false_alarms", "n_same")}


def choice_table(table: pd.DataFrame, name: str, trials: Trials, unit: str) -> pd.DataFrame:
    """The table `name` of choices as a person reads it; `unit` is that of the levels."""
    if name == "preference":
        table = _with_units(table, compared_factor(trials))
    if name == "same_different":
        table = _with_counts(table).rename(columns=SENSITIVITIES)
        table = table.rename(columns={"level": f"level ({unit})"}) if unit else table
    is_noted = "note" in table.columns and (table["note"] != "").any()
    return table if is_noted else table.drop(columns="note", errors="ignore")


def _with_counts(table: pd.DataFrame) -> pd.DataFrame:
    """A count and its number of trials in one column: ``3 of 4``."""
    for name, (part, whole) in COUNTS.items():
        both = [f"{k} of {n}" for k, n in zip(table[part], table[whole], strict=True)]
        table = table.assign(**{part: both}).rename(columns={part: name}).drop(columns=whole)
    return table


def compared_factor(trials: Trials) -> str:
    """The factor whose levels each trial compares: its column holds nothing. Empty if not just one is so."""
    stated = stated_factors(list(trials.rows.columns))
    bare = [name for name in stated if not trials.rows[name].replace("", None).notna().any()]
    return bare[0] if len(bare) == 1 else ""


def _with_units(table: pd.DataFrame, factor: str) -> pd.DataFrame:
    """Items with the unit of their factor, within each condition in the order of their numbers."""
    if not factor:
        return table
    ordered = table.sort_values("item", key=lambda item: parsed(item).fillna(float("inf")), kind="stable")
    conditions = list(table.columns[: table.columns.get_loc("item")])
    ordered = ordered.sort_values(conditions, kind="stable") if conditions else ordered
    return ordered.assign(item=[text if text == ORDER else level_of(factor, text) for text in ordered["item"]])
