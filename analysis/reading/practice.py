"""Practice: who missed its criterion."""

from collections.abc import Mapping
from typing import Any

import pandas as pd

from tactometry.arguments.require import whole
from tactometry.trials.tasks import PRACTICE_CRITERION, TASKS, YES_OR_NO

from .rows import correctness, holds, is_catch, numbers_of
from .study_file import study_table
from .trials import Trials


def missed_practice(trials: Trials) -> "pd.Series[bool]":
    """Return, for each participant with practice, True if a session ended it without meeting the criterion.

    Empty where the study of the data set has no practice.
    """
    criterion = study_table(trials.path, "practice", _criterion)
    rows = trials.rows
    if criterion is None:
        return pd.Series(dtype=bool)
    n_correct, n_of = criterion
    rows = rows[holds(rows, "practice", 1) & ~holds(rows, "valid", 0) & ~is_catch(rows)]
    keys = [name for name in ("participant", "session") if name in rows.columns]
    right = _is_right(rows).groupby([rows[name] for name in keys], sort=True)
    missed = right.apply(lambda answers: answers.tail(n_of).sum() < n_correct)
    return missed.groupby(level=0).any().astype(bool)


def _criterion(table: Mapping[str, Any]) -> tuple[int, int] | None:
    """Return how many of how many answers must be right; None without one."""
    if not table:
        return None
    stated = dict(zip(("n_correct", "n_of"), PRACTICE_CRITERION, strict=True)) | dict(table)
    whole("practice", lowest=1, n_correct=stated["n_correct"], n_of=stated["n_of"])
    return stated["n_correct"], stated["n_of"]


def _is_right(rows: pd.DataFrame) -> "pd.Series[bool]":
    """Return True for answers that the rule counts; a task that judges nothing has no wrong ones."""
    by_response = rows["task"].isin([name for name, task in TASKS.items() if task.response is YES_OR_NO])
    counted = (numbers_of(rows["response"]) == 1).where(by_response, correctness(rows) != 0)
    return counted.astype(bool)
