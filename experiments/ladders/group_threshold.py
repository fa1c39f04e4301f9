"""What participants buy: the error of a group's threshold against how many are measured."""

from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactometry.analysis.threshold.fitting import fit_many
from tactometry.psychometric import PsychometricFunction

from ..cost.problem import Problem, Real, Reference, Rung, error_of_decibels

MEAN_DB, BETWEEN_SD_DB = 20.0, 5.0
LEVELS_DB, N_TRIALS = np.linspace(2.0, 38.0, 10), 16
FUNCTION = PsychometricFunction("gumbel", MEAN_DB, 10.0, 0.5, 0.02)
N_PARTICIPANTS, N_GROUPS = (4, 16, 64, 256), 30


def problem() -> Problem:
    """Participants whose thresholds differ by 5 dB, each with 16 trials at each of ten levels."""
    return Problem(
        f"standard error of the group's threshold as a part of the amplitude, {N_GROUPS} simulated groups",
        reference=Reference("the mean that was simulated", lambda: np.array([MEAN_DB]), 0.0),
        independent=Reference("a fit to answers without scatter", _without_scatter_db, 0.02),
        error=error_of_decibels,
        rungs=tuple(Rung(f"{n} participants", partial(_means_db, n), float(n)) for n in N_PARTICIPANTS),
        price="participants, 160 trials each",
    )


def _means_db(n_participants: int) -> Real:
    """(n_groups,): mean fitted thresholds."""
    rng = np.random.default_rng(0)
    true_db = MEAN_DB + BETWEEN_SD_DB * rng.standard_normal((N_GROUPS, n_participants))
    return np.asarray(_fitted_db(rng.binomial(N_TRIALS, _chances(true_db)), N_TRIALS).mean(axis=1))


def _without_scatter_db() -> Real:
    """One participant of the mean threshold, whose answers come as often as they should."""
    many = 10_000
    return np.asarray(_fitted_db(np.round(many * _chances(np.full((1, 1), MEAN_DB))), many)[0])


def _chances(true_db: Real) -> Real:
    return np.asarray(FUNCTION.probability(LEVELS_DB - true_db[..., None] + MEAN_DB))


def _fitted_db(n_correct: NDArray[Any], n_trials: int) -> Real:
    counts = n_correct.reshape(-1, len(LEVELS_DB))
    fits = fit_many(LEVELS_DB, counts, n_trials, shape="gumbel", guess_rate=0.5, lapse_rate=0.02)
    thresholds_db = [MEAN_DB if fit.threshold is None else fit.threshold for fit in fits]
    return np.array(thresholds_db).reshape(n_correct.shape[:-1])
