"""Counts and fits by participant and condition, and rates by level."""

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from tactometry.trials.tasks import tasks_with_level

from ..arrays import Array
from ..means import rate_interval
from ..reading.rows import bad_cell, correctness, delivered_level, is_catch, numbers_of
from ..reading.trials import Trials
from ..threshold.equality import fit_comparisons
from ..threshold.fitting import ThresholdFit, fit_many
from .cell import Cell, Estimate, catch_counts, cell_keys, counted_cells, stacked_counts
from .kinds import CURVES

LEVELLED_TASKS = tasks_with_level("curve", "scale", "ratio")
UNIT = "level_unit"
CHOICES = tuple(name for name, curve in CURVES.items() if curve.scored_by == "correct")
"""Forced choices; their responses alone do not show whether an answer is correct."""
STATED = "n_alternatives"
BY_CHANCE = 0.001
"""Probability of never using the highest alternative by chance, below which a condition does not have it (unverified
default)."""
COUNTING = frozenset(name for name, curve in CURVES.items() if curve.counts_catch)
"""Tasks whose guess rate is estimated from catch trials."""
COLUMNS = (
    *("task", "threshold", "interval_low", "interval_high", "level_unit", "status", "width", "width_low", "width_high"),
    *("guess_rate", "lapse_rate", "n_trials", "n_levels", "n_catch", "n_false_alarms", "deviance", "threshold_mode"),
    *("threshold_median", "threshold_mean", "probability_below", "probability_within", "probability_above", "method"),
    *("shape", "interval", "note"),
)
"""Columns of the table of estimates that follow participant and condition."""


def level_unit(trials: Trials) -> str:
    """Return the common unit of the levels, or "".

    Raises `InvalidFile` if the analysed levels have several units.
    """
    if UNIT not in trials.rows.columns:
        return ""
    rows = trials.rows[trials.rows["task"].isin(LEVELLED_TASKS) & (trials.rows[UNIT] != "")]
    units = rows[UNIT].unique()
    if len(units) > 1:
        other = rows[rows[UNIT] == units[1]].iloc[0]
        expected = f"{units[0]!r} as in earlier rows; analyse levels of different units separately"
        raise bad_cell(other, UNIT, repr(units[1]), expected)
    if len(units):
        return str(units[0])
    others = set(trials.rows[UNIT]) - {""}
    return others.pop() if len(others) == 1 else ""


def cells(answers: pd.DataFrame, factors: Sequence[str]) -> list[Cell]:
    """Count the answers of each participant in each condition and task."""
    return counted_cells(answers.assign(n_choices=alternatives(answers, factors)), factors)


def judgements(used: pd.DataFrame) -> pd.DataFrame:
    """Return rows of tasks with a function, with `yes` and level `x`.

    `yes` is 1 or 0, or NaN if it is unknown.
    """
    rows = used[used["task"].isin(CURVES)]
    yes = numbers_of(rows["response"]).where(~rows["task"].isin(CHOICES), correctness(rows))
    return rows.assign(yes=yes, is_catch=is_catch(rows), x=delivered_level(rows))


def counted_answers(judged: pd.DataFrame) -> pd.DataFrame:
    """Return the judgements in which `yes` is known."""
    return judged[judged["yes"].notna()]


def count_table(cells: Sequence[Cell], factors: Sequence[str]) -> pd.DataFrame:
    """Return the counts with one row per participant, condition and level."""
    rows: list[tuple[float | str, ...]] = []
    for cell in cells:
        names = (cell.participant, *cell.condition, cell.task)
        rows += [(*names, *counts) for counts in zip(cell.levels, cell.n_yes, cell.n_trials, strict=True)]
    return pd.DataFrame(rows, columns=[*cell_keys(factors), "level", "n_yes", "n_trials"])


def alternatives(answers: pd.DataFrame, factors: Sequence[str]) -> "pd.Series[float]":
    """Return the number of alternatives of each row (2 if no forced choice).

    The number is stated in `n_alternatives`, or inferred as the highest interval that was chosen or a target. If a
    condition may lack the overall highest interval by chance (probability above `BY_CHANCE`), it has the overall
    number.

    Raises `InvalidFile` if `n_alternatives` varies within a condition.
    """
    number = pd.Series(2.0, index=answers.index)
    rows = answers[answers["task"].isin(CHOICES)]
    if rows.empty:
        return number
    conditions = [rows[name] for name in factors] + [rows["task"]]
    used = numbers_of(rows["response"])
    if "target" in rows.columns:
        used = used.where(~(rows["target"] > used.fillna(0)), rows["target"])
    of_condition = used.groupby(conditions, observed=True)
    largest, n = of_condition.transform("max").clip(lower=2), of_condition.transform("count")
    overall = largest.max()
    inferred = largest.mask((1 - 1 / overall) ** n > BY_CHANCE, overall)
    number[rows.index] = _stated(rows, conditions).fillna(inferred)
    return number


def _stated(rows: pd.DataFrame, conditions: Sequence["pd.Series[Any]"]) -> "pd.Series[float]":
    if STATED not in rows.columns:
        return pd.Series(np.nan, index=rows.index)
    of_condition = rows[STATED].groupby(list(conditions), observed=True)
    lowest, highest = of_condition.transform("min"), of_condition.transform("max")
    if (lowest < highest).any():
        several = lowest < highest
        found = f"{lowest[several].iloc[0]:g} and {highest[several].iloc[0]:g} in one condition"
        expected = "one number in each condition; name the factor that changes it with --within"
        raise bad_cell(rows[several].iloc[0], STATED, found, expected)
    return highest


def estimates(cells: Sequence[Cell], unit: str = "", interval: float = 0.95) -> list[Estimate]:
    """Fit every cell, in batches of equal task and number of alternatives."""
    fits: dict[Cell, ThresholdFit] = {}
    for task, n_choices in curves_of(cells):
        alike = [cell for cell in cells if (cell.task, cell.n_choices) == (task, n_choices)]
        n_false_alarms, n_catch = catch_counts(alike, COUNTING)
        curve = CURVES[task]
        fit_all = fit_comparisons if curve.has_difference else partial(fit_many, estimate=curve.estimate)
        found = fit_all(
            *stacked_counts(alike),
            **curve.options(n_choices, unit),
            interval=interval,
            n_false_alarms=n_false_alarms,
            n_catch=n_catch,
        )
        fits |= dict(zip(alike, found, strict=True))
    return [Estimate(cell, fits[cell]) for cell in cells]


def curves_of(cells: Sequence[Cell]) -> list[tuple[str, int]]:
    """Return each combination of task and number of alternatives."""
    found = {(cell.task, cell.n_choices) for cell in cells}
    return [(task, n) for task in CURVES for n in sorted(n for name, n in found if name == task)]


def estimate_table(estimates: Sequence[Estimate], factors: Sequence[str], unit: str) -> pd.DataFrame:
    """Return the fits as a table with one row per participant and condition.

    `threshold` is the detection threshold, or for comparisons the point of subjective equality (also `pse`). `jnd` is
    the distance from the `pse` to the level called "more" in 75 % of trials.
    """
    rows = []
    for cell, fit in ((estimate.cell, estimate.fit) for estimate in estimates):
        values = vars(cell) | vars(fit) | {"level_unit": unit, "status": fit.status.value}
        row: dict[str, object] = {"participant": cell.participant, **dict(zip(factors, cell.condition, strict=True))}
        row |= {name: values[name] for name in COLUMNS}
        if CURVES[cell.task].has_difference:
            row |= {"pse": fit.threshold, "jnd": fit.jnd, "jnd_low": fit.jnd_low, "jnd_high": fit.jnd_high}
        rows.append(row)
    return pd.DataFrame(rows)


MAX_LEVELS = 16
"""Largest number of levels for rates; more levels are pooled into classes."""


def detection_rates(counts: pd.DataFrame, factors: Sequence[str]) -> pd.DataFrame:
    """Return rates by condition and level, pooled over participants.

    More than `MAX_LEVELS` levels are pooled into classes of equal width, with their mean as level.
    """
    table = counts.drop(columns="participant")
    levels, n_trials = (table[name].to_numpy(dtype=float) for name in ("level", "n_trials"))
    table["level"] = _classes(levels, n_trials)
    rates = table.groupby([*factors, "task", "level"], sort=True, observed=True).sum().reset_index()
    low, high = rate_interval(rates["n_yes"], rates["n_trials"])
    return rates.assign(rate=rates["n_yes"] / rates["n_trials"], rate_low=low, rate_high=high)


def _classes(levels: Array, weights: Array) -> Array:
    if len(np.unique(levels)) <= MAX_LEVELS:
        return levels
    edges = np.linspace(levels.min(), levels.max(), MAX_LEVELS + 1)
    place = np.clip(np.digitize(levels, edges) - 1, 0, MAX_LEVELS - 1)
    total = np.bincount(place, weights, MAX_LEVELS)
    mean = np.bincount(place, weights * levels, MAX_LEVELS) / np.maximum(total, 1e-300)
    return np.asarray(mean[place])


def mean_rates(counts: pd.DataFrame, factors: Sequence[str]) -> pd.DataFrame:
    """Return rates over all levels, averaged over participants."""
    keys = [*factors, "task"]
    sums = counts.groupby(["participant", *keys], observed=True)[["n_yes", "n_trials"]].sum().reset_index()
    rates = sums.assign(rate=sums["n_yes"] / sums["n_trials"])
    return rates.groupby(keys, sort=True, observed=True)["rate"].agg(rate="mean", sd="std", n="size").reset_index()
