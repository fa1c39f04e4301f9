"""Participants together: mean thresholds per condition, and how often was felt what."""

import math
from collections.abc import Sequence

import numpy as np
import pandas as pd
from scipy.stats import t as student
from statsmodels.stats.proportion import proportion_confint

from tactometry.analysis.cells import Cell
from tactometry.analysis.counts import Array
from tactometry.analysis.design import RELATIVE_ZERO, size_of
from tactometry.analysis.number_text import interval_text
from tactometry.analysis.status import Status
from tactometry.analysis.table import Trials

MAX_LEVELS = 16
"""More levels than this are drawn together for the rates."""
MOST_COLUMNS = 8
"""Conditions across a table of text."""
BOUNDED = ("threshold", "pse")
"""Values that have a bound where the status says so; a difference has none."""


def group_table(
    estimates: pd.DataFrame, factors: Sequence[str], dependent: str = "threshold", interval: float = 0.95
) -> pd.DataFrame:
    """One row per condition: mean over participants with its interval (t, between participants), SD and n.

    A condition with a censored participant has no mean but a bound: the mean with every censored threshold at
    its own bound. `n_below`, `n_above` and `n_missing` count what is no threshold.
    """
    if not factors:
        return pd.DataFrame([_group(estimates, dependent, interval)])
    grouped = estimates.groupby(list(factors), sort=True, observed=True)
    rows = [dict(zip(factors, key, strict=True)) | _group(part, dependent, interval) for key, part in grouped]
    return pd.DataFrame(rows)


def _group(part: pd.DataFrame, dependent: str, interval: float) -> dict[str, object]:
    known = part[dependent].dropna().astype(float)
    is_level = dependent in BOUNDED
    n_below = int((part["status"] == Status.BELOW.value).sum()) if is_level else 0
    n_above = int((part["status"] == Status.ABOVE.value).sum()) if is_level else 0
    row: dict[str, object] = dict.fromkeys(("mean", "mean_low", "mean_high", "sd"))
    row |= {"n": len(known), "n_below": n_below, "n_above": n_above}
    row["n_missing"] = len(part) - len(known) - n_below - n_above
    if n_below or n_above:
        row |= _bounded(part, known, n_below, n_above)
    elif len(known):
        row |= mean_with_interval(np.array(known, dtype=np.float64), interval)
    return row | {"text": _text(row, len(part))}


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


def _bounded(part: pd.DataFrame, known: "pd.Series[float]", n_below: int, n_above: int) -> dict[str, object]:
    """A bound of the mean: possible only if all censored participants are on one side."""
    if n_below and n_above:
        return {}
    status, column = (Status.BELOW, "interval_high") if n_below else (Status.ABOVE, "interval_low")
    bounds = part.loc[part["status"] == status.value, column].astype(float)
    mean = float(pd.concat([known, bounds]).mean())
    return {"mean_high": mean} if n_below else {"mean_low": mean}


def _text(row: dict[str, object], n: int) -> str:
    if row["mean"] is not None:
        alike = ", all alike" if row["sd"] == 0 else ""
        lost = f", {row['n_missing']} missing" if row["n_missing"] else ""
        return f"{interval_text(row['mean'], row['mean_low'], row['mean_high'])} (n = {row['n']}{alike}{lost})"
    if row["n_below"] and row["n_above"]:
        return f"{row['n_below']} below, {row['n_above']} above the levels, of {n}"
    if row["n_below"]:
        return f"< {interval_text(row['mean_high'])} ({row['n_below']} of {n} below the levels)"
    if row["n_above"]:
        return f"> {interval_text(row['mean_low'])} ({row['n_above']} of {n} above the levels)"
    return f"none ({n} missing)"


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
