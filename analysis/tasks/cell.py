"""Counts of answers of cells, and arrays of them for batches of fits."""

from collections.abc import Container, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from ..arrays import Array
from ..means import parts
from ..threshold.fitting import ThresholdFit


@dataclass(frozen=True)
class Cell:
    """Counts of answers of one participant in one condition, by level.

    `n_yes` counts "yes", correct, or "more" answers, without catch trials. `n_choices` is the number of alternatives of
    a forced choice.
    """

    participant: str
    condition: tuple[float | str, ...]
    task: str
    levels: tuple[float, ...]
    n_yes: tuple[int, ...]
    n_trials: tuple[int, ...]
    n_catch: int
    n_false_alarms: int
    n_choices: int = 2


@dataclass(frozen=True)
class Estimate:
    """A cell with the fit of its psychometric function."""

    cell: Cell
    fit: ThresholdFit


def cell_keys(factors: Sequence[str]) -> list[str]:
    """Return the columns that identify the cell of a trial."""
    return ["participant", *factors, "task"]


def counted_cells(answers: pd.DataFrame, factors: Sequence[str]) -> list[Cell]:
    """Count answers by cell, sorted by `cell_keys`.

    Required columns are `yes`, `is_catch`, the level `x` and `n_choices`.
    """
    keys = cell_keys(factors)
    # select columns first, as grouping all of them is slow
    return [_cell(key, rows) for key, rows in parts(answers[[*keys, "is_catch", "x", "yes", "n_choices"]], keys)]


def _cell(key: tuple[Any, ...], rows: pd.DataFrame) -> Cell:
    catch, x, yes = (rows[name].to_numpy() for name in ("is_catch", "x", "yes"))
    at = ~catch & ~np.isnan(x)
    levels, place = np.unique(x[at], return_inverse=True)
    return Cell(
        participant=str(key[0]),
        condition=key[1:-1],
        task=str(key[-1]),
        levels=tuple(levels.tolist()),
        n_yes=tuple(np.bincount(place, yes[at]).astype(int).tolist()),
        n_trials=tuple(np.bincount(place).tolist()),
        n_catch=int(catch.sum()),
        n_false_alarms=int(yes[catch].sum()),
        n_choices=int(rows["n_choices"].iloc[0]),
    )


def stacked_counts(cells: Sequence[Cell]) -> tuple[Array, Array, Array]:
    """Stack levels, "yes" answers and trials as (n_cells, n_levels).

    Short rows are padded with levels without trials.
    """
    columns = [(cell.levels, cell.n_yes, cell.n_trials) for cell in cells]
    # at least one slot, as a cell may contain only catch trials
    stacked = np.zeros((3, len(cells), max([1, *(len(cell.levels) for cell in cells)])))
    for place, counts in enumerate(columns):
        stacked[:, place, : len(counts[0])] = counts
    levels, n_yes, n_trials = stacked
    return levels, n_yes, n_trials


def catch_counts(cells: Sequence[Cell], counting: Container[str]) -> tuple[list[int], list[int]]:
    """Return false alarms and catch trials; 0 for tasks not in `counting`."""
    used = [(cell.n_false_alarms, cell.n_catch) if cell.task in counting else (0, 0) for cell in cells]
    return [n_false_alarms for n_false_alarms, _ in used], [n_catch for _, n_catch in used]
