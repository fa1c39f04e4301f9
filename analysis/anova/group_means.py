"""Means by condition, with intervals and numbers of bounds.

A between-participants interval covers the mean of a condition. A within-participants interval shows differences between
conditions: it is Cousineau's (2005, Tutorials in Quantitative Methods for Psychology 1, 42-45) with Morey's correction
(2008, the same journal 4, 61-64), computed from values minus the participant's mean. Two means differ if such
intervals, multiplied by sqrt(1 / 2), do not overlap (Baguley 2012, Behavior Research Methods 44, 158-175).
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from ..arrays import Array, size_of
from ..distributions import Student
from ..means import ANY, FEWEST_IN_RANGE, POSITIVE, RATE, Range, mean_with_interval, parts
from ..wording import ends_text, interval_text

BOUNDS: Mapping[str, tuple[str, str]] = {
    "threshold": ("interval_low", "interval_high"),
    "pse": ("interval_low", "interval_high"),
    "jnd": ("jnd_low", "jnd_high"),
}
"""Columns of the bounds of an unknown value, by dependent variable."""
RANGES: Mapping[str, Range] = {"rate_correct": RATE, "jnd": POSITIVE}
"""Range of each dependent variable whose values are limited."""
LOW, HIGH = "lower_bound", "upper_bound"
LEVELS = ("threshold", "pse")
"""Dependent variables whose bound is the lowest or highest level."""
MEANS = ("mean", "mean_low", "mean_high", "sd", "within_low", "within_high")
WITHIN = MEANS[4:]
COUNTS = ("n", "n_below", "n_above", "n_interval", "n_missing")
OUT = ("threshold_below_range", "threshold_above_range")
"""Statuses of values outside the range of the levels; the single bound shows the side."""
MODEL = "censored model"
OF_FIT = "interval of the fit"
DIFFERENCE = float(np.sqrt(0.5))
"""Factor of the within-participants intervals after which a gap means a difference (Baguley 2012)."""


def group_table(
    estimates: pd.DataFrame,
    factors: Sequence[str],
    dependent: str = "threshold",
    interval: float = 0.95,
    model: pd.DataFrame | None = None,
    possible: Range | None = None,
) -> pd.DataFrame:
    """Return mean, SD, n and intervals of each condition.

    `n_below` and `n_above` count values below or above the levels, `n_interval` values known only by an interval,
    `n_missing` unknown values. The mean of a condition with bounds comes from `model` (the result of
    `CensoredAnova.means`), or is missing without a model; `method` names the source. With a single participant the
    intervals are those of the fit (`OF_FIT`). Intervals stay within the `possible` range, by default that of `RANGES`.
    """
    possible = RANGES.get(dependent, ANY) if possible is None else possible
    halves = {} if model is not None else _within_halves(estimates, factors, dependent, interval)
    rows = []
    for key, condition in parts(bounds_of(estimates, dependent), factors):
        names = dict(zip(factors, key, strict=True))
        of_model = None if model is None else _row_of(model, names)
        rows.append(names | _group(condition, dependent, interval, halves.get(key), of_model, possible))
    table = pd.DataFrame(rows)
    is_one = "participant" in estimates.columns and estimates["participant"].nunique() == 1
    return _with_own_intervals(table, estimates, factors, dependent) if is_one else table


def _with_own_intervals(
    table: pd.DataFrame, estimates: pd.DataFrame, factors: Sequence[str], dependent: str
) -> pd.DataFrame:
    """Use the intervals of the fits in a table of one participant."""
    if dependent not in BOUNDS or not set(BOUNDS[dependent]) <= set(estimates.columns):
        return table
    rows: list[dict[Any, Any]] = table.to_dict("records")
    for row, (_, condition) in zip(rows, parts(estimates, factors), strict=True):
        low, high = (condition[name].astype(float).iloc[0] for name in BOUNDS[dependent])
        if len(condition) == 1 and row["n"] == 1 and np.isfinite([low, high]).all():
            row |= {"mean_low": low, "mean_high": high, "method": OF_FIT}
            row["text"] = f"{interval_text(row['mean'], low, high)} (n = 1)"
        elif len(condition) == row["n_interval"] == 1:
            row["text"] = f"{ends_text(low, high)} ({condition['status'].iloc[0]})"
    return pd.DataFrame(rows, columns=table.columns)


def is_of_fit(means: pd.DataFrame) -> bool:
    """Return True if the intervals come from the fits of a single participant."""
    return "method" in means.columns and bool((means["method"] == OF_FIT).any())


def bounds_of(estimates: pd.DataFrame, dependent: str) -> pd.DataFrame:
    """Add the columns `lower_bound` and `upper_bound` of unknown values."""
    ends = {}
    for name, column in zip((LOW, HIGH), BOUNDS.get(dependent, ("", "")), strict=True):
        bounds = estimates[column].astype(float) if column in estimates.columns else pd.Series(np.nan, estimates.index)
        ends[name] = bounds.where(estimates[dependent].isna())
    return estimates.assign(**ends)


def _row_of(model: pd.DataFrame, names: Mapping[str, object]) -> "pd.Series[float] | None":
    """Return the model's row of a condition, or None if there is none."""
    shared = [name for name in names if name in model.columns]
    rows = model[(model[shared] == [names[name] for name in shared]).all(axis=1)]
    return rows.iloc[0] if len(rows) == 1 else None


def _within_halves(
    estimates: pd.DataFrame, factors: Sequence[str], dependent: str, interval: float
) -> dict[tuple[object, ...], float]:
    """Return half the within-participants interval of each condition."""
    if "participant" not in estimates.columns or not factors:
        return {}
    varied = estimates.groupby("participant")[list(factors)].nunique().max() > 1
    within, between = ([name for name in factors if bool(varied[name]) is is_varied] for is_varied in (True, False))
    if not within:
        return {}
    by_condition = {}
    for group, members in parts(estimates, between):
        wide = members.pivot_table(dependent, "participant", within, dropna=False, observed=True, aggfunc="mean")
        for condition, half in _halves(wide, interval).items():
            value_of = dict(zip([*between, *within], [*group, *condition], strict=True))
            by_condition[tuple(value_of[name] for name in factors)] = half  # keys in the order of `factors`
    return by_condition


def _halves(wide: pd.DataFrame, interval: float) -> dict[tuple[object, ...], float]:
    values = wide.to_numpy(dtype=np.float64)
    n = len(values)
    if n < 2 or not np.isfinite(values).all():
        return {}
    size = size_of(values)
    covariance = np.asarray(np.cov(values / size, rowvar=False), dtype=np.float64)
    variances = within_variances(covariance.reshape(wide.shape[1], -1))
    halves = float(Student.ppf((1 + interval) / 2, n - 1)) * np.sqrt(variances / n) * size
    names = [tuple(name) for name in wide.columns.to_frame().itertuples(index=False, name=None)]
    return dict(zip(names, halves.tolist(), strict=True))


def _group(
    rows: pd.DataFrame,
    dependent: str,
    interval: float,
    half: float | None,
    model: "pd.Series[float] | None",
    possible: Range,
) -> dict[str, object]:
    known = rows[dependent].dropna().to_numpy(dtype=np.float64)
    has_low, has_high = rows[LOW].notna(), rows[HIGH].notna()
    is_out = rows["status"].isin(OUT) if "status" in rows.columns else True
    n_below, n_above = int((has_high & ~has_low & is_out).sum()), int((has_low & ~has_high & is_out).sum())
    n_interval = int((has_low | has_high).sum()) - n_below - n_above
    n_missing = len(rows) - len(known) - n_below - n_above - n_interval

    row: dict[str, Any] = dict.fromkeys(MEANS)
    if len(known) and not (n_below or n_above):
        row |= mean_with_interval(known, interval, possible)
    if half is not None and row["mean"] is not None and (len(known) >= FEWEST_IN_RANGE or not possible.is_bounded):
        row |= dict(zip(WITHIN, possible.around(row["mean"], half), strict=True))
    is_whole = len(known) == len(rows)
    if model is not None:
        row |= _of_model(model, WITHIN if is_whole else MEANS, possible)
    method = "t" if is_whole or model is None else MODEL
    row |= {"method": "" if row["mean"] is None else method}
    row |= {"n": len(known), "n_below": n_below, "n_above": n_above, "n_interval": n_interval, "n_missing": n_missing}
    return row | {"text": _text(row, len(rows), "the levels" if dependent in LEVELS else "a bound")}


def _of_model(model: "pd.Series[float]", names: Sequence[str], possible: Range) -> dict[str, float]:
    """Return values of a model's row, limited to the possible range."""
    row = {name: float(model[name]) for name in names}
    for low, high in (MEANS[1:3], WITHIN):
        if low in row:
            row |= dict(zip((low, high), possible.around(model["mean"], model[high] - model["mean"]), strict=True))
    return row


def _text(row: Mapping[str, Any], n: int, where: str) -> str:
    sides = [f"{row[f'n_{side}']} {side}" for side in ("below", "above") if row[f"n_{side}"]]
    unknown = [f"{', '.join(sides)} {where}"] if sides else []
    if row["n_interval"]:
        unknown.append(f"{row['n_interval']} known by an interval only")
    if row["n_missing"] and (unknown or row["n"]):
        unknown.append(f"{row['n_missing']} missing")
    if row["mean"] is None:
        return f"of {n}: {', '.join(unknown)}" if unknown else f"none ({n} missing)"
    alike = ["all alike"] if row["sd"] == 0 else []
    counts = ", ".join([f"n = {row['n']}", *alike, *unknown])
    return f"{interval_text(row['mean'], row['mean_low'], row['mean_high'])} ({counts})"


def within_variances(covariance: Array) -> Array:
    """Return variances of conditions after removing participant means."""
    k = len(covariance)
    if k < 2:
        return np.full(k, np.nan)
    centre = np.eye(k) - 1 / k
    return np.asarray(np.diagonal(centre @ covariance @ centre) * k / (k - 1))
