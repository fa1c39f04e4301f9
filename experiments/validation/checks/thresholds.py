"""Checks of single participants' thresholds, by procedure and fit."""

from collections.abc import Iterable, Mapping
from functools import partial
from typing import Any, Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from tactometry.analysis.hierarchical.fitting import fit_hierarchical
from tactometry.analysis.threshold.fitting import ThresholdFit, fit_many
from tactometry.protocols import MethodOfLimits
from tactometry.protocols.bayesian.settings import PsiSettings
from tactometry.protocols.procedures.procedure import Rule
from tactometry.psychometric import PsychometricFunction

from ...bias_study import participants as simulated
from ...bias_study.participants import (
    AT_CHANCE,
    HIGH_DB,
    INSIDE,
    LAPSE_RATE,
    LOW_DB,
    SHAPE,
    TASKS,
    SimulatedTask,
    Tracks,
)
from ..check import Simulate

N_TRIALS: Final = 60
N_GROUP: Final = 10
"""Number of participants in a hierarchical fit."""
CHOSEN: Final = TASKS[1:3]
"""Tasks: yes/no with catch trials, and two alternatives."""
POSTERIOR: Final = ("mode", "median", "mean")


def method_of_limits(guess_rate: float) -> MethodOfLimits:
    """Return series that start in the outer quarter and end with the trials."""
    del guess_rate
    return MethodOfLimits(LOW_DB, HIGH_DB, 4.0, n_series=1000, n_start_steps=2)


def psi(guess_rate: float) -> Rule[Any]:
    """Return the psi method for a cumulative normal with the true lapse rate."""
    table = PsiSettings(
        LOW_DB, HIGH_DB, 41, 1.0, 6.0, 6, guess_rate=guess_rate, lapse_rate=LAPSE_RATE, n_trials=N_TRIALS
    )
    return table.procedure()


PROCEDURES: Final = {**simulated.PROCEDURES, "psi": psi, "method of limits": method_of_limits}
LEFT_OUT: Final = (AT_CHANCE, ("method of limits", "2AFC"))
"""Excluded combinations: these rules lower the level after each answer 1, including correct guesses."""
TARGETS: Final[Mapping[str, float]] = {
    "1 up 1 down": 0.5,
    "1 up 2 down": 0.5 ** (1 / 2),
    "1 up 3 down": 0.5 ** (1 / 3),
    "weighted, 0.75": 0.75,
    "method of limits": 0.5,
}
"""Probability of the answer 1 at the target of a rule (Levitt 1971, J. Acoust. Soc. Am. 49, 467; Kaernbach 1991,
Percept. Psychophys. 49, 227). Other procedures estimate the threshold."""


def outcomes(procedure: str, task: SimulatedTask, n_sets: int, rng: np.random.Generator) -> pd.DataFrame:
    """Simulate one track per participant, and apply all fits."""
    made = simulated.tracks(procedure, task, INSIDE, n_sets, rng, n_trials=N_TRIALS, procedures=PROCEDURES)
    n_catch = round(task.catch * N_TRIALS)
    catch = {"n_false_alarms": rng.binomial(n_catch, task.guess_rate, n_sets), "n_catch": np.full(n_sets, n_catch)}
    given: dict[str, Any] = {"shape": SHAPE, "guess_rate": task.told}
    by_fit = {"the rule's own": _of_rule(procedure, task, made)} | _of_fits(made, given | catch)
    groups = [slice(first, first + N_GROUP) for first in range(0, len(made.answers), N_GROUP)]
    by_fit["hierarchical"] = pd.concat([_of_group(made, given, catch, members) for members in groups])
    tables = [table.assign(procedure=procedure, task=task.name, fit=fit) for fit, table in by_fit.items()]
    return pd.concat([table for table in tables if table["estimate"].notna().any()], ignore_index=True)


def _of_rule(procedure: str, task: SimulatedTask, made: Tracks) -> pd.DataFrame:
    targets = {**TARGETS, "QUEST": 1 - (1 - task.guess_rate) / np.e}
    people = zip(made.thresholds_db, made.widths_db, strict=True)
    functions = [PsychometricFunction(SHAPE, at, width, task.guess_rate, LAPSE_RATE) for at, width in people]
    target = targets.get(procedure)
    truth = made.thresholds_db if target is None else [function.level(target) for function in functions]
    return pd.DataFrame({"truth": truth, "estimate": made.rule_db, "low": np.nan, "high": np.nan})


def _of_fits(made: Tracks, given: Mapping[str, Any]) -> dict[str, pd.DataFrame]:
    """Return three estimates from the posterior, which share an interval."""
    fits = fit_many(*_counts(made), **given, scale_free_width=True)
    by_fit = {
        f"posterior, {name}": _table(made, fits, [getattr(fit, f"threshold_{name}") for fit in fits])
        for name in POSTERIOR
    }
    by_fit["posterior, mode"] = _table(made, fits, [fit.threshold for fit in fits])
    return by_fit


def _counts(made: Tracks) -> tuple[NDArray[np.float64], ...]:
    """Return levels, answers and trials (0 after the end of a track)."""
    presented = ~np.isnan(made.levels_db)
    return (
        np.where(presented, made.levels_db, 0.0),
        np.where(presented, made.answers, 0.0),
        presented.astype(np.float64),
    )


def _table(made: Tracks, fits: Iterable[ThresholdFit], estimates: Iterable[float | None]) -> pd.DataFrame:
    """Return estimates and intervals."""
    rows = [
        (None if fit.threshold is None else estimate, fit.interval_low, fit.interval_high)
        for fit, estimate in zip(fits, estimates, strict=True)
    ]
    table = pd.DataFrame(rows, columns=["estimate", "low", "high"], dtype=np.float64)
    return table.assign(truth=made.thresholds_db)


def _of_group(
    made: Tracks, given: Mapping[str, Any], catch: Mapping[str, NDArray[Any]], members: slice
) -> pd.DataFrame:
    counts = [part[members] for part in _counts(made)]
    n_people, n_trials = counts[0].shape
    names = np.repeat([f"P{place:02d}" for place in range(n_people)], n_trials).tolist()
    own_catch = {name: np.repeat(numbers[members], n_trials) for name, numbers in catch.items()}
    condition = {"condition": ["all"] * len(names)}
    levels, n_correct, n_asked = (part.ravel() for part in counts)
    options: dict[str, Any] = {**given, **own_catch}
    result = fit_hierarchical(levels, n_correct, n_asked, names, condition, **options).participants
    columns = {"threshold": "estimate", "interval_low": "low", "interval_high": "high"}
    people = result.sort_values("participant")[list(columns)].rename(columns=columns).astype(float)
    return people.assign(truth=made.thresholds_db[members])


SETTINGS: Final[Mapping[str, Simulate]] = {
    f"{procedure}, {task.name}": partial(outcomes, procedure, task)
    for procedure in PROCEDURES
    for task in CHOSEN
    if (procedure, task.name) not in LEFT_OUT
}
