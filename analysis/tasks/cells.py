"""Each participant in each condition: counts per level, then a threshold, or an equality point and a difference; and
how often was felt what, against the level and over all levels."""

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from tactometry.trials.tasks import tasks_with_level

from ..arrays import Array
from ..means import parts, rate_interval
from ..reading.rows import bad_cell, correctness, delivered_level, is_catch, numbers_of
from ..reading.trials import Trials
from ..threshold.equality import fit_comparisons
from ..threshold.fitting import ThresholdFit, fit_many
from .cell import Cell, Estimate, catch_counts, cell_keys, stacked_counts
from .kinds import CURVES

LEVELLED_TASKS = tasks_with_level("curve", "scale", "ratio")
UNIT = "level_unit"
CHOICES = tuple(name for name, curve in CURVES.items() if curve.scored_by == "correct")
"""Forced choices, whose responses alone do not say what was right."""
STATED = "n_alternatives"
BY_CHANCE = 0.001
"""A condition has fewer alternatives than others if chance explains that with less than this (unverified default)."""
COUNTING = frozenset(name for name, curve in CURVES.items() if curve.counts_catch)
"""Tasks whose guess rate rests on catch trials."""
COLUMNS = (
    *("task", "threshold", "interval_low", "interval_high", "level_unit", "status", "width", "width_low", "width_high"),
    *("guess_rate", "lapse_rate", "n_trials", "n_levels", "n_catch", "n_false_alarms", "deviance", "threshold_mode"),
    *("threshold_median", "threshold_mean", "probability_below", "probability_within", "probability_above", "method"),
    *("shape", "interval", "note"),
)
"""Of the table of estimates, behind participant and condition."""


def level_unit(trials: Trials) -> str:
    """The one unit of the levels that are analysed, or of all where none are; empty if the table names none, or several
    of levels that are not analysed.

    Raises
    ------
    InvalidFile
        If there is more than one.
    """
    if UNIT not in trials.rows.columns:
        return ""
    rows = trials.rows[trials.rows["task"].isin(LEVELLED_TASKS) & (trials.rows[UNIT] != "")]
    units = rows[UNIT].unique()
    if len(units) > 1:
        other = rows[rows[UNIT] == units[1]].iloc[0]
        expected = f"{units[0]!r} as before; analyse levels of different units apart"
        raise bad_cell(other, UNIT, repr(units[1]), expected)
    if len(units):
        return str(units[0])
    others = set(trials.rows[UNIT]) - {""}
    return others.pop() if len(others) == 1 else ""


def cells(answers: pd.DataFrame, factors: Sequence[str]) -> list[Cell]:
    """The cells of judgements that count (`counted_answers`), ordered by participant, condition and task."""
    keys = cell_keys(factors)
    counted = answers[[*keys, "is_catch", "x", "yes"]]  # parts of all columns take most of the time
    counted = counted.assign(n_choices=alternatives(answers, factors))
    return [_cell(key, rows, len(factors)) for key, rows in parts(counted, keys)]


def judgements(used: pd.DataFrame) -> pd.DataFrame:
    """Of the used rows those to which a curve is fitted, as they stand, with `yes` (1 or 0; NaN: not known), `is_catch`
    and the level `x`."""
    rows = used[used["task"].isin(CURVES)]
    return rows.assign(yes=_yes(rows), is_catch=is_catch(rows), x=delivered_level(rows))


def counted_answers(judged: pd.DataFrame) -> pd.DataFrame:
    """The judgements that count."""
    return judged[judged["yes"].notna()]


def _yes(rows: pd.DataFrame) -> "pd.Series[float]":
    """1 for yes, correct or more; 0 for the opposite; NaN where a forced choice says neither what was right."""
    return numbers_of(rows["response"]).where(~rows["task"].isin(CHOICES), correctness(rows))


def _cell(key: tuple[Any, ...], rows: pd.DataFrame, n_factors: int) -> Cell:
    catch, x, yes = (rows[name].to_numpy() for name in ("is_catch", "x", "yes"))
    at = ~catch & ~np.isnan(x)
    levels, place = np.unique(x[at], return_inverse=True)
    return Cell(
        participant=str(key[0]),
        condition=tuple(key[1 : 1 + n_factors]),
        task=str(key[-1]),
        levels=tuple(levels.tolist()),
        n_yes=tuple(np.bincount(place, yes[at]).astype(int).tolist()),
        n_trials=tuple(np.bincount(place).tolist()),
        n_catch=int(catch.sum()),
        n_false_alarms=int(yes[catch].sum()),
        n_choices=int(rows["n_choices"].iloc[0]),
    )


def count_table(cells: Sequence[Cell], factors: Sequence[str]) -> pd.DataFrame:
    """A row per participant, condition and level: what the curves are fitted to."""
    rows: list[tuple[float | str, ...]] = []
    for cell in cells:
        names = (cell.participant, *cell.condition, cell.task)
        rows += [(*names, *counts) for counts in zip(cell.levels, cell.n_yes, cell.n_trials, strict=True)]
    return pd.DataFrame(rows, columns=["participant", *factors, "task", "level", "n_yes", "n_trials"])


def alternatives(answers: pd.DataFrame, factors: Sequence[str]) -> "pd.Series[float]":
    """Return for each row how many alternatives a forced choice of its condition has; 2 in other tasks.

    It is the number stated in `n_alternatives`, else the largest interval that was chosen or a target in the condition.
    A condition in which the largest of all is missing by chance, with a probability above `BY_CHANCE`, has that number.

    Raises
    ------
    InvalidFile
        If a condition states two numbers.
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
        expected = "one number in each condition; name its factor with --within, or this column"
        raise bad_cell(rows[several].iloc[0], STATED, found, expected)
    return highest


def estimates(cells: Sequence[Cell], unit: str = "", interval: float = 0.95) -> list[Estimate]:
    """Fit every cell, those of one task and number of alternatives in one batch; in the order of the cells.

    By the posterior, its mode and marginal intervals, with what the curve of the task knows of its rates.
    """
    fits: dict[Cell, ThresholdFit] = {}
    for task, n_choices in curves_of(cells):  # cells of a batch share the options of the fit, and one call is faster
        alike = [cell for cell in cells if (cell.task, cell.n_choices) == (task, n_choices)]
        fits |= dict(zip(alike, _fits(alike, task, n_choices, unit, interval), strict=True))
    return [Estimate(cell, fits[cell]) for cell in cells]


def curves_of(cells: Sequence[Cell]) -> list[tuple[str, int]]:
    """Return the tasks of cells, in the order of `CURVES`, with each number of alternatives."""
    found = {(cell.task, cell.n_choices) for cell in cells}
    return [(task, n) for task in CURVES for n in sorted(n for name, n in found if name == task)]


def _fits(cells: Sequence[Cell], task: str, n_choices: int, unit: str, interval: float) -> tuple[ThresholdFit, ...]:
    n_false_alarms, n_catch = catch_counts(cells, COUNTING)
    curve = CURVES[task]
    fit_all = fit_comparisons if curve.has_difference else partial(fit_many, estimate=curve.estimate)
    return fit_all(
        *stacked_counts(cells),
        **curve.options(n_choices, unit),
        interval=interval,
        n_false_alarms=n_false_alarms,
        n_catch=n_catch,
    )


def estimate_table(estimates: Sequence[Estimate], factors: Sequence[str], unit: str) -> pd.DataFrame:
    """One row per participant and condition; empty where the data do not tell.

    `threshold` is the detection threshold, or the point of subjective equality (also as `pse`) in a
    comparison, where `jnd` is the distance from it to the level that is called "more" in 75 % of trials.
    """
    return pd.DataFrame([_row(estimate, factors, unit) for estimate in estimates])


def _row(estimate: Estimate, factors: Sequence[str], unit: str) -> dict[str, object]:
    cell, fit = estimate.cell, estimate.fit
    values = vars(cell) | vars(fit) | {"level_unit": unit, "status": fit.status.value}
    row: dict[str, object] = {"participant": cell.participant, **dict(zip(factors, cell.condition, strict=True))}
    row |= {name: values[name] for name in COLUMNS}
    return row | _difference(fit) if CURVES[cell.task].has_difference else row


def _difference(fit: ThresholdFit) -> dict[str, float | None]:
    return {"pse": fit.threshold, "jnd": fit.jnd, "jnd_low": fit.jnd_low, "jnd_high": fit.jnd_high}


MAX_LEVELS = 16
"""More levels than this are drawn together for the rates."""


def detection_rates(counts: pd.DataFrame, factors: Sequence[str]) -> pd.DataFrame:
    """Rate of "yes", correct or "more" against the level in each condition, all participants together, from the
    table of counts.

    With Wilson's interval, which treats the answers as independent. Levels are drawn together into
    `MAX_LEVELS` classes of equal width, named by their mean, where there are more.
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
    """Mean over participants of the rate over all levels, in each condition (the thesis's detection
    rates)."""
    keys = [*factors, "task"]
    sums = counts.groupby(["participant", *keys], observed=True)[["n_yes", "n_trials"]].sum().reset_index()
    rates = sums.assign(rate=sums["n_yes"] / sums["n_trials"])
    return rates.groupby(keys, sort=True, observed=True)["rate"].agg(rate="mean", sd="std", n="size").reset_index()
