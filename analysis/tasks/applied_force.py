"""Applied force, and share of time in the target band."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from ..means import POSITIVE, by_condition, mean_row
from ..reading.quality import TARGET
from ..wording import decimals_of, percent_text

MEASURED = ("force_mean_n", "force_sd_n", "force_in_band")


def has_force(rows: pd.DataFrame) -> bool:
    """Return True if the applied force was measured."""
    return "force_mean_n" in rows.columns and bool(rows["force_mean_n"].notna().any())


def force_of_participants(used: pd.DataFrame, factors: Sequence[str]) -> pd.DataFrame:
    """Return mean force, SD and time in band by participant and condition.

    The SD is the mean standard deviation within trials. If force is a factor, the deviation from the target is added.
    """
    rows = used[used["force_mean_n"].notna()]
    keys = ["participant", *factors]
    known = [name for name in MEASURED if name in rows.columns]
    grouped = rows.groupby(keys, sort=True, observed=True)
    means = grouped[known].mean().join(grouped.size().rename("n_trials")).reset_index()
    if TARGET in factors:
        means["force_deviation_n"] = means["force_mean_n"] - means[TARGET].astype(float)
    return means


def force_table(of_participants: pd.DataFrame, factors: Sequence[str]) -> pd.DataFrame:
    """Return the mean force of each condition with its t-interval.

    This is table 6.2 of the thesis.
    """
    return by_condition(of_participants, factors, _force_row)


def _force_row(means: pd.DataFrame) -> dict[str, object]:
    values = np.array(means["force_mean_n"], dtype=np.float64)
    row = mean_row(values, possible=POSITIVE) | {"n": len(values), "n_trials": int(means["n_trials"].sum())}
    band = ""
    if "force_in_band" in means.columns and means["force_in_band"].notna().any():
        in_band = float(means["force_in_band"].mean())
        row["in_band"], band = in_band, f", {percent_text(in_band)} in band"
    mean = float(values.mean())
    sd = "" if row["sd"] is None else f" ± {row['sd']:.{decimals_of(mean)}f}"
    return row | {"text": f"{mean:.{decimals_of(mean)}f}{sd} N{band}"}
