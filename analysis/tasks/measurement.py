"""Loss of amplitude by condition, computed from measured levels."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from ..means import AT_MOST_1, by_condition, mean_row, mean_with_interval
from ..reading.rows import bad_cell
from .task_analysis import Results, TaskAnalysis

TASK = "measurement"
NEEDED = ("level_unit", "level_measured")


def loss_of(level: pd.Series, measured: pd.Series, in_db: "pd.Series[bool]") -> "pd.Series[float]":
    """Return the loss 1 - A' / A, from decibels if `in_db`.

    >>> loss_of(pd.Series([20.0, 4.0]), pd.Series([14.0, 3.0]), pd.Series([True, False])).round(3).tolist()
    [0.499, 0.25]
    """
    # Evaluate each formula only for its unit, as division by 0 dB or exponents of amplitudes would overflow.
    left = pd.Series(np.where(in_db, measured - level, 0.0), level.index)
    share = np.divide(measured, level, out=np.ones(len(level)), where=~in_db.to_numpy())
    return pd.Series(1 - np.where(in_db, 10 ** (left / 20), share), level.index)


def losses(rows: pd.DataFrame, factors: Sequence[str]) -> pd.DataFrame:
    """Return mean `loss` and force by participant and condition.

    Raises `InvalidFile` if a stated amplitude is 0.
    """
    if any(name not in rows.columns for name in NEEDED):
        return pd.DataFrame()
    rows = rows[rows["level"].notna() & rows["level_measured"].notna()]
    in_db = rows["level_unit"].str.startswith("dB")
    nothing = rows[~in_db & (rows["level"] == 0)]
    if len(nothing):
        raise bad_cell(nothing.iloc[0], "level", "0", "an amplitude above 0")
    level, measured = (rows[name].astype(float) for name in ("level", "level_measured"))
    readings = rows.assign(loss=loss_of(level, measured, in_db))
    return by_condition(readings, ["participant", *factors], _reading)


def loss_table(rows: pd.DataFrame, factors: Sequence[str]) -> pd.DataFrame:
    """Return the mean loss by condition, with its interval over participants.

    With a single participant, the interval is over readings.
    """
    return by_condition(losses(rows, factors), factors, _condition)


def _reading(readings: pd.DataFrame) -> dict[str, object]:
    mean = mean_with_interval(readings["loss"].to_numpy(float), possible=AT_MOST_1)
    mean = dict.fromkeys(("mean", "mean_low", "mean_high")) | mean
    row = {name.replace("mean", "loss"): value for name, value in mean.items()} | {"n_readings": len(readings)}
    if "force_mean_n" in readings.columns and readings["force_mean_n"].notna().any():
        row["force_mean_n"] = float(readings["force_mean_n"].mean())
    return row


def _condition(participants: pd.DataFrame) -> dict[str, object]:
    row = mean_row(participants["loss"].to_numpy(float), possible=AT_MOST_1)
    if len(participants) == 1:  # the interval is over the participant's readings
        row |= {f"mean{end}": participants[f"loss{end}"].iloc[0] for end in ("", "_low", "_high")}
    row |= {"n": len(participants), "n_readings": int(participants["n_readings"].sum())}
    if "force_mean_n" in participants.columns:
        row["force_mean_n"] = float(participants["force_mean_n"].mean())
    text = f"{100 * float(str(row['mean'])):.1f} %"
    if row["mean_low"] is not None and row["mean_high"] is not None:
        text += f" [{100 * float(str(row['mean_low'])):.1f}, {100 * float(str(row['mean_high'])):.1f}]"
    return row | {"text": text}


ANALYSIS = TaskAnalysis(
    "A sensor measured the stimulus",
    "lme4::lmer(level_measured ~ {plus} + (1 | participant), {data})",
    results=Results({"loss_participants": losses, "loss": loss_table}),
)
