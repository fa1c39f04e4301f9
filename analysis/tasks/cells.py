"""Each participant in each condition: counts per level, then a threshold, or an equality point and a
difference."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from scipy.special import ndtri

from tactometry.errors import InvalidFile
from tactometry.psychometric import SHAPES
from tactometry.trials.tasks import tasks_with_level

from ..conditions import parts
from ..reading.level_scale import is_logarithm
from ..reading.trials import Trials, parsed
from ..threshold.fitting import ThresholdFit, fit_many

FITTED_TASKS = tasks_with_level("curve")
LEVELLED_TASKS = tasks_with_level("curve", "scale", "ratio")
SHAPE = "normal"
DETECTION_SHAPE_IN_DB = "gumbel"
JND_PER_SD = float(ndtri(0.75))
"""The just noticeable difference over the standard deviation of the normal function: 0.6745."""
DIFFERENCE_PER_WIDTH = JND_PER_SD / SHAPES[SHAPE].z_width
COMPARISON: Mapping[str, Any] = {
    "guess_rate": None,
    "equal_asymptotes": True,
    "rate_beta": 80.0,
    "scale_free_width": True,
    "narrowest_spacings": 0.5,
}
"""Who lapses in a comparison says either with the same chance: both asymptotes are half of the rate of lapses, whose
mean is 2.5 % under Beta(1, 80). The width, a scale, has a prior flat in its logarithm, from one spacing of the levels
on: psignifit's, which falls below two, holds small differences up. Of the priors tried these cover best between 0 and
5 % lapses (`benchmarks/census_comparisons.py`); unverified defaults."""
UNIT = "level_unit"
Rows = np.ndarray[tuple[int, int], np.dtype[np.float64]]


@dataclass(frozen=True)
class Cell:
    """Answers of one participant in one condition: `levels`, `n_yes`, `n_trials` of equal length.

    `n_yes` counts "yes", correct, or "more" answers. Catch trials stand apart.
    """

    participant: str
    condition: tuple[float | str, ...]
    task: str
    levels: tuple[float, ...]
    n_yes: tuple[int, ...]
    n_trials: tuple[int, ...]
    n_catch: int
    n_false_alarms: int


@dataclass(frozen=True)
class Estimate:
    """A cell with its fit."""

    cell: Cell
    fit: ThresholdFit


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
        raise InvalidFile(
            f"{other['source']}, row {other['row']}, column 'level_unit': found {units[1]!r}, expected {units[0]!r} "
            "as before; analyse levels of different units apart"
        )
    others = set(trials.rows[UNIT]) - {""}
    return str(units[0]) if len(units) else others.pop() if len(others) == 1 else ""


def cells(answered: pd.DataFrame, factors: Sequence[str]) -> list[Cell]:
    """The cells of judgements that are `answered`, ordered by participant, condition and task."""
    return [_cell(key, part, len(factors)) for key, part in parts(answered, cell_keys(factors))]


def cell_keys(factors: Sequence[str]) -> list[str]:
    """The columns by which trials are of one cell."""
    return ["participant", *factors, "task"]


def judgements(used: pd.DataFrame) -> pd.DataFrame:
    """Of the used rows those to which a curve is fitted, as they stand, with `yes` (1 or 0; NaN: not known), `is_catch`
    and the level `x`."""
    rows = used[used["task"].isin(FITTED_TASKS)]
    return rows.assign(yes=_yes(rows), is_catch=is_catch(rows), x=delivered(rows))


def answered(judged: pd.DataFrame) -> pd.DataFrame:
    """The judgements that count."""
    return judged[judged["yes"].notna()]


def _yes(rows: pd.DataFrame) -> "pd.Series[float]":
    """1 for yes, correct or more; 0 for the opposite; NaN where a forced choice says neither what was
    right."""
    answer = parsed(rows["response"])
    correct = rows["correct"] if "correct" in rows.columns else pd.Series(np.nan, index=rows.index)
    if "target" in rows.columns:
        right = (answer == rows["target"]).astype(float).where(rows["target"].notna())
        correct = correct.fillna(right)
    return answer.where(rows["task"] != "forced_choice", correct)


def is_catch(rows: pd.DataFrame) -> "pd.Series[bool]":
    return rows["catch"] == 1 if "catch" in rows.columns else pd.Series(False, index=rows.index)


def delivered(rows: pd.DataFrame) -> "pd.Series[float]":
    """The level that was delivered where that is known, else the one that was asked for."""
    if "level_delivered" not in rows.columns:
        return rows["level"]
    return rows["level_delivered"].fillna(rows["level"])


def _cell(key: tuple[Any, ...], part: pd.DataFrame, n_factors: int) -> Cell:
    catch = part["is_catch"].to_numpy()
    felt = part[~catch]
    counts = felt.groupby("x")["yes"].agg(["sum", "count"])
    return Cell(
        participant=str(key[0]),
        condition=tuple(key[1 : 1 + n_factors]),
        task=str(key[-1]),
        levels=tuple(float(x) for x in counts.index),
        n_yes=tuple(int(k) for k in counts["sum"]),
        n_trials=tuple(int(n) for n in counts["count"]),
        n_catch=int(catch.sum()),
        n_false_alarms=int(part["yes"].to_numpy()[catch].sum()),
    )


def count_table(found: Sequence[Cell], factors: Sequence[str]) -> pd.DataFrame:
    """A row per participant, condition and level: what the curves are fitted to."""
    rows = [
        (cell.participant, *cell.condition, cell.task, level, k, n)
        for cell in found
        for level, k, n in zip(cell.levels, cell.n_yes, cell.n_trials, strict=True)
    ]
    return pd.DataFrame(rows, columns=["participant", *factors, "task", "level", "n_yes", "n_trials"])


def n_alternatives(trials: Trials) -> int:
    """Alternatives of the forced choice: the largest interval ever chosen or used as target, at least 2."""
    rows = trials.rows[trials.rows["task"] == "forced_choice"]
    answers = parsed(rows["response"])
    largest = answers.max() if "target" not in rows.columns else max(answers.max(), rows["target"].max())
    return max(2, int(largest)) if np.isfinite(largest) else 2


def shape_of(unit: str) -> str:
    """The psychometric function of detection: Weibull's of the amplitude, which is a Gumbel in decibels
    (Watson 1979, Vision Res. 19, 515), where levels are logarithms; else the cumulative normal."""
    return DETECTION_SHAPE_IN_DB if is_logarithm(unit) else SHAPE


def estimates(found: Sequence[Cell], n_choices: int, unit: str = "", interval: float = 0.95) -> list[Estimate]:
    """Fit every cell, those of one task in one batch; in the order of the cells.

    By the posterior, its mode and marginal intervals, with the rates of `fit_options` and the catch trials of yes/no.
    """
    fits: dict[Cell, ThresholdFit] = {}
    for task in FITTED_TASKS:
        chosen = [cell for cell in found if cell.task == task]
        if chosen:
            fits |= dict(zip(chosen, _fits(chosen, task, n_choices, unit, interval), strict=True))
    return [Estimate(cell, fits[cell]) for cell in found]


def _fits(chosen: Sequence[Cell], task: str, n_choices: int, unit: str, interval: float) -> tuple[ThresholdFit, ...]:
    n_false_alarms, n_catch = catch_counts(chosen)
    return fit_many(
        *stacked_counts(chosen),
        **fit_options(task, n_choices, unit),
        interval=interval,
        n_false_alarms=n_false_alarms,
        n_catch=n_catch,
    )


def stacked_counts(chosen: Sequence[Cell]) -> tuple[Rows, Rows, Rows]:
    """Levels, yes and trials of cells, (n_cells, most levels), filled up with places without trials."""
    return _stack([c.levels for c in chosen]), _stack([c.n_yes for c in chosen]), _stack([c.n_trials for c in chosen])


def catch_counts(chosen: Sequence[Cell]) -> tuple[list[int], list[int]]:
    """False alarms and catch trials of cells as a fit uses them: only detection asks for a rate of false alarms."""
    asked = [cell.task == "yes_no" for cell in chosen]
    return (
        [cell.n_false_alarms * is_asked for cell, is_asked in zip(chosen, asked, strict=True)],
        [cell.n_catch * is_asked for cell, is_asked in zip(chosen, asked, strict=True)],
    )


def fit_options(task: str, n_choices: int, unit: str) -> dict[str, Any]:
    """The shape of the function and what is known of its rates and width.

    A forced choice has a known chance of guessing right; of a comparison `COMPARISON` is known.
    """
    if task == "comparison":
        return {"shape": SHAPE, **COMPARISON}
    guess_rate = 1 / n_choices if task == "forced_choice" else None
    return {"shape": shape_of(unit), "guess_rate": guess_rate, "scale_free_width": True}


def _stack(rows: Sequence[Sequence[float]]) -> Rows:
    """Rows of different lengths, filled up with zeros: no trials there."""
    stacked = np.zeros((len(rows), max(1, *(len(row) for row in rows)) if rows else 1))
    for place, row in enumerate(rows):
        stacked[place, : len(row)] = row
    return stacked


def estimate_table(found: Sequence[Estimate], factors: Sequence[str], unit: str) -> pd.DataFrame:
    """One row per participant and condition; empty where the data do not tell.

    `threshold` is the detection threshold, or the point of subjective equality (also as `pse`) in a
    comparison, where `jnd` is 0.6745 standard deviations.
    """
    return pd.DataFrame([_row(estimate, factors, unit) for estimate in found])


def _row(estimate: Estimate, factors: Sequence[str], unit: str) -> dict[str, object]:
    cell, fit = estimate.cell, estimate.fit
    row: dict[str, object] = {"participant": cell.participant}
    row |= dict(zip(factors, cell.condition, strict=True))
    row |= {
        "task": cell.task,
        "threshold": fit.threshold,
        "interval_low": fit.interval_low,
        "interval_high": fit.interval_high,
        "level_unit": unit,
        "status": fit.status.value,
        "width": fit.width,
        "width_low": fit.width_low,
        "width_high": fit.width_high,
        "guess_rate": fit.guess_rate,
        "lapse_rate": fit.lapse_rate,
        "n_trials": fit.n_trials,
        "n_levels": fit.n_levels,
        "n_catch": cell.n_catch,
        "n_false_alarms": cell.n_false_alarms,
        "deviance": fit.deviance,
        "threshold_mode": fit.threshold_mode,
        "threshold_median": fit.threshold_median,
        "threshold_mean": fit.threshold_mean,
        "probability_below": fit.probability_below,
        "probability_within": fit.probability_within,
        "probability_above": fit.probability_above,
        "method": fit.method,
        "shape": fit.shape,
        "interval": fit.interval,
        "note": fit.note,
    }
    return row | (_difference(fit) if cell.task == "comparison" else {})


def _difference(fit: ThresholdFit) -> dict[str, float | None]:
    names = {"jnd": fit.width, "jnd_low": fit.width_low, "jnd_high": fit.width_high}
    scaled = {name: None if width is None else width * DIFFERENCE_PER_WIDTH for name, width in names.items()}
    return {"pse": fit.threshold, **scaled}
