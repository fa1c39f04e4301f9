"""A cell of a study: the counts of one participant in one condition, alone and stacked for a batch of fits; this module
knows no task."""

from collections.abc import Container, Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..threshold.fitting import ThresholdFit


@dataclass(frozen=True)
class Cell:
    """Answers of one participant in one condition: `levels`, `n_yes`, `n_trials` of equal length.

    `n_yes` counts "yes", correct, or "more" answers. Catch trials stand apart. `n_choices` are the alternatives of a
    forced choice.
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
    """A cell with its fit."""

    cell: Cell
    fit: ThresholdFit


def cell_keys(factors: Sequence[str]) -> list[str]:
    """The columns by which trials are of one cell."""
    return ["participant", *factors, "task"]


def stacked_counts(cells: Sequence[Cell]) -> tuple[Array, Array, Array]:
    """Levels, yes and trials of cells, (n_cells, most levels), filled up with places without trials."""
    levels = _stack([cell.levels for cell in cells])
    n_yes, n_trials = _stack([cell.n_yes for cell in cells]), _stack([cell.n_trials for cell in cells])
    return levels, n_yes, n_trials


def catch_counts(cells: Sequence[Cell], counting: Container[str]) -> tuple[list[int], list[int]]:
    """False alarms and catch trials of cells as a fit uses them: none but where the guess rate rests on them."""
    used = [(cell.n_false_alarms, cell.n_catch) if cell.task in counting else (0, 0) for cell in cells]
    return [n_false_alarms for n_false_alarms, _ in used], [n_catch for _, n_catch in used]


def _stack(rows: Sequence[Sequence[float]]) -> Array:
    """Rows of different lengths, filled up with zeros: no trials there."""
    stacked = np.zeros((len(rows), max([1, *map(len, rows)])))  # a place at least: a cell may have catch trials alone
    for place, row in enumerate(rows):
        stacked[place, : len(row)] = row
    return stacked
