"""Accuracy problems of procedures: numbers of trials and participants."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from tactometry.analysis.threshold.fitting import fit_many
from tactometry.protocols import ConstantStimuli, Quest, QuestPlus, Staircase
from tactometry.protocols.bayesian.parameter_grid import ParameterGrid
from tactometry.protocols.procedures.procedure import Procedure, Rule
from tactometry.psychometric import PsychometricFunction

from ..measure import Problem, Real, Reference, Setting, error_of_decibels

LOW_DB, MIDDLE_DB, HIGH_DB, SD_DB = 0.0, 20.0, 40.0, 3.0
WIDTH_DB, GUESS_RATE, LAPSE_RATE = 10.1, 0.5, 0.02
N_TRIALS, N_RUNS, TRIAL_S = (24, 96, 384), 30, 4.0
LEVELS_DB = tuple(np.arange(LOW_DB, HIGH_DB + 1, 2).tolist())
CONSTANT_DB = (8.0, 12.0, 16.0, 20.0, 24.0, 28.0)
FUNCTION = PsychometricFunction("gumbel", MIDDLE_DB, WIDTH_DB, GUESS_RATE, LAPSE_RATE)
FIT: dict[str, Any] = {"shape": "gumbel", "guess_rate": GUESS_RATE, "lapse_rate": LAPSE_RATE}
GROUP_SD_DB, GROUP_LEVELS_DB, N_AT_LEVEL = 5.0, np.linspace(2.0, 38.0, 10), 16
GROUP_FUNCTION = PsychometricFunction("gumbel", MIDDLE_DB, 10.0, GUESS_RATE, LAPSE_RATE)
N_PARTICIPANTS, N_GROUPS = (4, 16, 64, 256), 30
Run = tuple[Any, list[tuple[float, bool]]]
"""Finished procedure, and its levels with the answers."""


@dataclass(frozen=True)
class Method:
    """Procedure by number of trials, its threshold estimates and target rate."""

    rule: Callable[[int], Rule[Any]]
    thresholds_db: Callable[[Sequence[Run]], Sequence[float | None]]
    target: float


def problem() -> Problem:
    """Compare threshold errors of procedures in two-alternative tasks."""
    return Problem(
        f"rms error of the threshold as a fraction of the amplitude, two alternatives, {N_RUNS} simulated runs",
        reference=Reference("the simulated threshold", lambda: np.zeros(1), 0.0),
        error=error_of_decibels,
        settings=tuple(
            Setting(f"{n} trials", partial(_errors_db, method, n), n * TRIAL_S / 60, name)
            for name, method in METHODS.items()
            for n in N_TRIALS
        ),
        price="time per participant (min), 4 s per trial",
    )


def _errors_db(method: Method, n_trials: int) -> Real:
    """Return the errors (n_runs,). A missing threshold counts as the middle."""
    rngs = [np.random.default_rng(seed) for seed in np.random.SeedSequence(0).spawn(N_RUNS)]
    true_db = [MIDDLE_DB + SD_DB * float(rng.standard_normal()) for rng in rngs]
    runs = [_run(method.rule(n_trials).begin(rng), own_db, rng) for own_db, rng in zip(true_db, rngs, strict=True)]
    estimates_db = [MIDDLE_DB if level_db is None else level_db for level_db in method.thresholds_db(runs)]
    return np.asarray(np.subtract(estimates_db, true_db) - (FUNCTION.level(method.target) - MIDDLE_DB))


def _run(procedure: Procedure, threshold_db: float, rng: np.random.Generator) -> Run:
    answered = []
    while not procedure.finished:
        answered.append((procedure.level, bool(rng.random() < _chance(procedure.level - threshold_db))))
        procedure = procedure.after(answered[-1][1])
    return procedure, answered


def _chance(above_db: float) -> float:
    """Return the probability of a correct answer, from the Gumbel function."""
    spread = math.log(-math.log(0.05)) - math.log(-math.log(0.95))
    unscaled = -math.expm1(-math.log(2) * math.exp(spread * above_db / WIDTH_DB))
    return GUESS_RATE + (1 - GUESS_RATE - LAPSE_RATE) * unscaled


def _constant(n_trials: int) -> ConstantStimuli:
    return ConstantStimuli(CONSTANT_DB, n_trials // len(CONSTANT_DB))


def _staircase(n_trials: int) -> Staircase:
    return Staircase(MIDDLE_DB, (4.0, 2.0, 1.0), LOW_DB, HIGH_DB, n_reversals=n_trials, n_trials=n_trials)


def _quest(n_trials: int) -> Quest:
    blind = LAPSE_RATE / (1 - GUESS_RATE)
    return Quest(MIDDLE_DB, 10.0, LOW_DB, HIGH_DB, 0.5, blind_share=blind, n_trials=n_trials)


def _quest_plus(n_trials: int) -> QuestPlus:
    thresholds_db = tuple(np.arange(MIDDLE_DB - 4 * SD_DB, MIDDLE_DB + 4 * SD_DB + 0.5, 0.5).tolist())
    grid = ParameterGrid(thresholds_db, (7.0, 10.0, 14.0), lapse_rates=(LAPSE_RATE,))
    return QuestPlus(LEVELS_DB, grid, n_trials, aim="threshold")


def _by_fit(runs: Sequence[Run]) -> list[float | None]:
    answers = np.array([answered for _, answered in runs], dtype=np.float64)
    return [fit.threshold for fit in fit_many(answers[..., 0], answers[..., 1], 1, **FIT)]


def _by_rule(runs: Sequence[Run]) -> list[float | None]:
    return [procedure.threshold for procedure, _ in runs]


HALF = GUESS_RATE + (1 - GUESS_RATE - LAPSE_RATE) / 2
METHODS = {
    "constant stimuli": Method(_constant, _by_fit, HALF),
    "staircase": Method(_staircase, _by_rule, math.sqrt(0.5)),
    "QUEST": Method(_quest, _by_rule, 0.82),
    "QUEST+": Method(_quest_plus, _by_rule, HALF),
}


def group_threshold() -> Problem:
    """Compare errors of the mean threshold by the number of participants."""
    return Problem(
        f"standard error of the group's threshold as a fraction of the amplitude, {N_GROUPS} simulated groups",
        reference=Reference("the simulated mean", lambda: np.array([MIDDLE_DB]), 0.0),
        error=error_of_decibels,
        settings=tuple(Setting(f"{n} participants", partial(_group_means_db, n), float(n)) for n in N_PARTICIPANTS),
        price="participants with 160 trials each",
    )


def _group_means_db(n_participants: int) -> Real:
    rng = np.random.default_rng(0)
    true_db = MIDDLE_DB + GROUP_SD_DB * rng.standard_normal((N_GROUPS, n_participants))
    chances = GROUP_FUNCTION.probability(GROUP_LEVELS_DB - true_db[..., None] + MIDDLE_DB)
    n_correct = rng.binomial(N_AT_LEVEL, chances).reshape(-1, len(GROUP_LEVELS_DB))
    fits = fit_many(GROUP_LEVELS_DB, n_correct, N_AT_LEVEL, **FIT)
    thresholds_db = [MIDDLE_DB if fit.threshold is None else fit.threshold for fit in fits]
    return np.asarray(np.reshape(thresholds_db, true_db.shape).mean(axis=1))
