"""Statuses of estimates, and coverage, bias and length of intervals.

Each participant completes one track. The first n trials of a track serve as a track of n trials.
"""

import math
from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np
import pandas as pd

from tactometry.analysis.threshold.fitting import Status

from .participants import (
    AT_CHANCE,
    LAPSE_RATE,
    MOST_TRIALS,
    PLACES,
    PROCEDURES,
    TASKS,
    SimulatedTask,
    ends_of,
    fits,
    tracks,
)

N_TRIALS = (20, 30, 40, 80, MOST_TRIALS)
OUTCOMES = ("procedure", "task", "place", "n_trials", "status", "low_db", "high_db", "threshold_db", "true_db")
FEWEST = 20
"""Fewest thresholds for which a bias is computed."""
TOLD, OUT = (Status.OK, Status.SEPARATED), (Status.BELOW, Status.ABOVE)
COLUMNS = ("n", "ok", "separated", "out", "flat", "other", "covered", "covered_all", "bias_sd", "length_db")
Setting = tuple[str, SimulatedTask, str]


def settings(
    procedures: Sequence[str] = tuple(PROCEDURES),
    tasks: Sequence[SimulatedTask] = TASKS,
    places: Sequence[str] = PLACES,
) -> list[Setting]:
    """Return all combinations of procedure, task and place."""
    return [setting for setting in product(procedures, tasks, places) if (setting[0], setting[1].name) != AT_CHANCE]


def outcomes_of(
    chosen: Sequence[Setting],
    n_sets: int,
    rng: np.random.Generator,
    *,
    n_trials: Sequence[int] = N_TRIALS,
    lapse_rate: float = LAPSE_RATE,
) -> Iterator[pd.DataFrame]:
    """Yield a table of outcomes for each setting."""
    for (procedure, task, place), stream in zip(chosen, rng.spawn(len(chosen)), strict=True):
        simulated = tracks(procedure, task, place, n_sets, stream, n_trials=max(n_trials), lapse_rate=lapse_rate)
        rows = []
        for n in n_trials:
            result = fits(simulated, task, n, task.false_alarms(n, n_sets, stream))
            for one, true_db in zip(result, simulated.thresholds_db, strict=True):
                fit = one.status.value, *ends_of(one), one.threshold
                rows.append((procedure, task.name, place, n, *fit, true_db))
        yield pd.DataFrame(rows, columns=OUTCOMES).astype({"threshold_db": float})


def summary(outcomes: pd.DataFrame, by: Sequence[str]) -> pd.DataFrame:
    """Return operating characteristics, grouped in the order of the rows.

    The columns are shares of the statuses, coverage of the `ok` intervals (`covered`) and of all intervals
    (`covered_all`), bias in standard deviations, and median interval length of thresholds with a value.
    """
    rows = [(*key, *_row(each)) for key, each in outcomes.groupby(list(by), sort=False)]
    return pd.DataFrame(rows, columns=[*by, *COLUMNS])


def _row(outcomes: pd.DataFrame) -> tuple[float, ...]:
    shares = [outcomes["status"].isin(of).mean() for of in ((Status.OK,), (Status.SEPARATED,), OUT, (Status.FLAT,))]
    covers = outcomes["true_db"].between(outcomes["low_db"], outcomes["high_db"])
    is_ok, known = outcomes["status"] == Status.OK, outcomes[outcomes["status"].isin(TOLD)]
    bias, length_db = math.nan, math.nan
    if len(known) >= FEWEST:
        error_db = known["threshold_db"] - known["true_db"]
        bias = error_db.mean() / error_db.std(ddof=0)
        length_db = (known["high_db"] - known["low_db"]).median()
    return len(outcomes), *shares, 1 - sum(shares), covers[is_ok].mean(), covers.mean(), bias, length_db
