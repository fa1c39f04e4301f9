"""Participants together: mean thresholds per condition, and how often was felt what."""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import t as student
from statsmodels.stats.proportion import proportion_confint

from ..anova.within_intervals import within_variances
from ..arrays import RELATIVE_ZERO, Array, size_of
from ..reading.trials import Trials
from ..tasks.cells import Cell
from ..wording.numbers import interval_text

MAX_LEVELS = 16
"""More levels than this are drawn together for the rates."""
MOST_COLUMNS = 8
"""Conditions across a table of text."""
BOUNDS: Mapping[str, tuple[str, str]] = {
    "threshold": ("interval_low", "interval_high"),
    "pse": ("interval_low", "interval_high"),
    "jnd": ("jnd_low", "jnd_high"),
}
"""Where a value that is not known may have a bound: its columns. Other values have none."""
LOW, HIGH = "lower_bound", "upper_bound"
LEVELS = ("threshold", "pse")
"""Values whose bound is an end of the levels."""


def group_table(
    estimates: pd.DataFrame,
    factors: Sequence[str],
    dependent: str = "threshold",
    interval: float = 0.95,
    model: pd.DataFrame | None = None,
) -> pd.DataFrame:
    """One row per condition: mean over participants with its interval between participants (t; `mean_low`,
    `mean_high`), SD and n, and the interval within participants (Cousineau and Morey's; `within_low`, `within_high`).

    `n_below`, `n_above` and `n_missing` count the values of which an upper, a lower or no bound is known. A condition
    with bounds has no mean of its own: that of `model` (as `CensoredAnova.means`) stands there, and `method` says so;
    without one the numbers are empty.
    """
    inside = {} if model is not None else _inside(estimates, factors, dependent, interval)
    rows = []
    for key, part in _parts(bounds_of(estimates, dependent), factors):
        names = dict(zip(factors, key, strict=True))
        own = None if model is None else _row_of(model, names)
        rows.append(names | _group(part, dependent, interval, inside.get(key), own))
    return pd.DataFrame(rows)


def bounds_of(estimates: pd.DataFrame, dependent: str) -> pd.DataFrame:
    """The estimates with the bounds `lower_bound` and `upper_bound` of the values that are not known, where they have
    any."""
    unknown = estimates[dependent].isna()
    ends = {}
    for name, column in zip((LOW, HIGH), BOUNDS.get(dependent, ("", "")), strict=True):
        held = estimates[column].astype(float) if column in estimates.columns else pd.Series(np.nan, estimates.index)
        ends[name] = held.where(unknown)
    return estimates.assign(**ends)


def _row_of(model: pd.DataFrame, names: Mapping[str, object]) -> "pd.Series[float] | None":
    """The row of a condition, by those factors that the model has."""
    shared = [name for name in names if name in model.columns]
    found = model[(model[shared] == [names[name] for name in shared]).all(axis=1)]
    return found.iloc[0] if len(found) == 1 else None


def _inside(
    estimates: pd.DataFrame, factors: Sequence[str], dependent: str, interval: float
) -> dict[tuple[object, ...], float]:
    """Half the interval within participants of each condition, where every participant (of a group) has all values."""
    if "participant" not in estimates.columns or not factors:
        return {}
    varied = estimates.groupby("participant")[list(factors)].nunique().max() > 1
    within, between = ([name for name in factors if bool(varied[name]) is is_varied] for is_varied in (True, False))
    if not within:
        return {}
    found = {}
    for group, part in _parts(estimates, between):
        wide = part.pivot_table(dependent, "participant", within, dropna=False, observed=True, aggfunc="mean")
        for condition, half in _halves(wide, interval).items():
            own = dict(zip([*between, *within], [*group, *condition], strict=True))
            found[tuple(own[name] for name in factors)] = half
    return found


def _parts(table: pd.DataFrame, keys: Sequence[str]) -> Iterable[tuple[tuple[Any, ...], pd.DataFrame]]:
    """The rows of each combination of values; all of them without keys."""
    return table.groupby(list(keys), sort=True, observed=True) if keys else [((), table)]


def _halves(wide: pd.DataFrame, interval: float) -> dict[tuple[object, ...], float]:
    values = wide.to_numpy(dtype=np.float64)
    n = len(values)
    if n < 2 or not np.isfinite(values).all():
        return {}
    size = size_of(values)
    covariance = np.asarray(np.cov(values / size, rowvar=False), dtype=np.float64)
    variances = within_variances(covariance.reshape(wide.shape[1], -1))
    halves = float(student.ppf((1 + interval) / 2, n - 1)) * np.sqrt(variances / n) * size
    names = [tuple(name) for name in wide.columns.to_frame().itertuples(index=False, name=None)]
    return dict(zip(names, halves.tolist(), strict=True))


MEANS = ("mean", "mean_low", "mean_high", "sd", "within_low", "within_high")


def _group(
    part: pd.DataFrame, dependent: str, interval: float, half: float | None, model: "pd.Series[float] | None"
) -> dict[str, object]:
    known = part[dependent].dropna().to_numpy(dtype=np.float64)
    n_below, n_above = (int((part[own].notna() & part[other].isna()).sum()) for own, other in _SIDES)
    row: dict[str, Any] = dict.fromkeys(MEANS)
    if len(known) and not (n_below or n_above):
        row |= mean_with_interval(known, interval)
    if half is not None and row["mean"] is not None:
        row |= {"within_low": row["mean"] - half, "within_high": row["mean"] + half}
    is_whole = len(known) == len(part)
    if model is not None:
        row |= {name: float(model[name]) for name in (MEANS[4:] if is_whole else MEANS)}
    row |= {"method": "" if row["mean"] is None else "t" if is_whole or model is None else MODEL}
    row |= {"n": len(known), "n_below": n_below, "n_above": n_above}
    row["n_missing"] = len(part) - len(known) - n_below - n_above
    return row | {"text": _text(row, len(part), "the levels" if dependent in LEVELS else "a bound")}


_SIDES = ((HIGH, LOW), (LOW, HIGH))
MODEL = "censored model"


def mean_with_interval(values: Array, interval: float) -> dict[str, object]:
    """Mean of one value at least, with SD of two, and t-interval where they differ.

    >>> {name: round(x, 3) for name, x in mean_with_interval(np.array([1.0, 2, 4]), 0.95).items()}
    {'mean': 2.333, 'mean_low': -1.461, 'mean_high': 6.128, 'sd': 1.528}
    """
    n, size = len(values), size_of(values)
    mean = float((values / size).mean())
    if n < 2:
        return {"mean": mean * size}
    sd = float((values / size).std(ddof=1))
    if sd <= RELATIVE_ZERO * float(np.abs(values / size).max()):
        return {"mean": mean * size, "sd": 0.0}
    half = float(student.ppf((1 + interval) / 2, n - 1)) * sd / float(np.sqrt(n))
    found = {"mean": mean, "mean_low": mean - half, "mean_high": mean + half, "sd": sd}
    return {name: value * size for name, value in found.items()}


def _text(row: Mapping[str, Any], n: int, where: str) -> str:
    sides = [f"{row[f'n_{side}']} {side}" for side in ("below", "above") if row[f"n_{side}"]]
    beside = [f"{', '.join(sides)} {where}"] if sides else []
    if row["n_missing"] and (sides or row["n"]):
        beside.append(f"{row['n_missing']} missing")
    if row["mean"] is None:
        return f"of {n}: {', '.join(beside)}" if beside else f"none ({n} missing)"
    told = ", ".join([f"n = {row['n']}", *(["all alike"] if row["sd"] == 0 else []), *beside])
    return f"{interval_text(row['mean'], row['mean_low'], row['mean_high'])} ({told})"


def cross_table(group: pd.DataFrame, factors: Sequence[str]) -> pd.DataFrame:
    """The thesis's form: the factor with most levels (frequency) down, the others (force) across; cells as text. Where
    that would be too wide, one factor, of numbers if there is one, runs across and the others down."""
    if len(factors) < 2:
        return group[[*factors, "text"]].rename(columns={"text": "mean"})
    down = max(factors, key=lambda name: group[name].nunique())
    across = [name for name in factors if name != down]
    if math.prod(group[name].nunique() for name in across) > MOST_COLUMNS:
        numeric = [name for name in factors if pd.api.types.is_numeric_dtype(group[name])]
        across = [max(numeric or [down], key=lambda name: group[name].nunique())]
    others = [name for name in factors if name not in across]
    table = group.pivot(index=others, columns=across, values="text")
    table.columns = [_column_name(across, key) for key in table.columns]
    return table.reset_index()


def _column_name(across: Sequence[str], key: object) -> str:
    values = key if isinstance(key, tuple) else (key,)
    return ", ".join(f"{name} = {_short(value)}" for name, value in zip(across, values, strict=True))


def _short(value: object) -> str:
    return f"{value:g}" if isinstance(value, int | float | np.number) else str(value)


def detection_rates(found: Sequence[Cell], factors: Sequence[str]) -> pd.DataFrame:
    """Rate of "yes", correct or "more" against the level in each condition, all participants together.

    With Wilson's interval, which treats the answers as independent. Levels are drawn together into
    `MAX_LEVELS` classes of equal width, named by their mean, where there are more.
    """
    rows = [
        (*cell.condition, cell.task, level, k, n)
        for cell in found
        for level, k, n in zip(cell.levels, cell.n_yes, cell.n_trials, strict=True)
    ]
    table = pd.DataFrame(rows, columns=[*factors, "task", "level", "n_yes", "n_trials"])
    table["level"] = _classes(table["level"].to_numpy(dtype=float), table["n_trials"].to_numpy(dtype=float))
    rates = table.groupby([*factors, "task", "level"], sort=True, observed=True).sum().reset_index()
    low, high = proportion_confint(rates["n_yes"], rates["n_trials"], method="wilson")
    rate = rates["n_yes"] / rates["n_trials"]
    return rates.assign(rate=rate, rate_low=np.minimum(low, rate), rate_high=np.maximum(high, rate))


def _classes(levels: Array, weights: Array) -> Array:
    if len(np.unique(levels)) <= MAX_LEVELS:
        return levels
    edges = np.linspace(levels.min(), levels.max(), MAX_LEVELS + 1)
    place = np.clip(np.digitize(levels, edges) - 1, 0, MAX_LEVELS - 1)
    total = np.bincount(place, weights, MAX_LEVELS)
    mean = np.bincount(place, weights * levels, MAX_LEVELS) / np.maximum(total, 1e-300)
    return np.asarray(mean[place])


def mean_rates(found: Sequence[Cell], factors: Sequence[str]) -> pd.DataFrame:
    """Mean over participants of the rate over all levels, in each condition (the thesis's detection
    rates)."""
    rows = [(*cell.condition, cell.task, sum(cell.n_yes) / sum(cell.n_trials)) for cell in found if sum(cell.n_trials)]
    table = pd.DataFrame(rows, columns=[*factors, "task", "rate"])
    grouped = table.groupby([*factors, "task"], sort=True, observed=True)["rate"]
    return grouped.agg(rate="mean", sd="std", n="size").reset_index()


def quality(trials: Trials) -> pd.DataFrame:
    """Per participant: what was recorded, what of it is used, and how the catch trials were answered."""
    rows = trials.rows
    flags = pd.DataFrame(
        {
            "participant": rows["participant"],
            "n_rows": 1,
            "n_practice": _is(rows, "practice", 1),
            "n_invalid": _is(rows, "valid", 0),
            "n_repeated": _is_repeated(rows),
            "n_unanswered": ((rows["response"] == "") & (_is(rows, "valid", 0) == 0)).astype(int),
        }
    )
    catch = _is(rows, "catch", 1) * (1 - _is(rows, "valid", 0)) * (1 - _is(rows, "practice", 1))
    catch *= (rows["response"] != "").astype(int)
    flags["n_catch"] = catch
    flags["n_false_alarms"] = catch * rows["response"].isin(["1", "1.0"]).astype(int)
    table = flags.groupby("participant", sort=True).sum()
    rate = table["n_false_alarms"] / table["n_catch"].where(table["n_catch"] > 0)
    return table.assign(false_alarm_rate=rate).reset_index()


def _is_repeated(rows: pd.DataFrame) -> "pd.Series[int]":
    """1 in the first row of each attempt behind the first: a questionnaire has a row for each of its items."""
    if "attempt" not in rows.columns:
        return pd.Series(0, index=rows.index)
    keys = ["participant", *(name for name in ("source", "session", "block", "trial", "attempt") if name in rows)]
    first = rows["item"].eq("") | ~rows.duplicated(keys) if "item" in rows.columns else True
    return ((rows["attempt"] > 1) & first).astype(int)


def _is(rows: pd.DataFrame, name: str, value: int) -> "pd.Series[int]":
    if name not in rows.columns:
        return pd.Series(0, index=rows.index)
    return (rows[name] == value).astype(int)
