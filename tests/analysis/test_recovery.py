"""Tests of the recovery of known thresholds, without a fixed seed."""

import numpy as np
import pytest
from scipy.stats import binom
from soak import SOAK

from tactometry.analysis.threshold.fitting import fit_many
from tactometry.psychometric import PsychometricFunction

pytestmark = pytest.mark.slow

LEVELS = np.linspace(8.0, 36.0, 8)
N_PARTICIPANTS = 2000 if SOAK else 200
MEAN_DB, SD_DB, LAPSE_RATE, FALSE_ALARM_RATE = 22.0, 2.5, 0.02, 0.05
COVERAGE, RARE = 0.935, 1e-4


@pytest.fixture(scope="module", params=[("yes_no", 15), ("yes_no", 40), ("forced_choice", 40)], ids=str)
def recovered(request):
    task, n = request.param
    rng = np.random.default_rng()
    truth = rng.normal(MEAN_DB, SD_DB, N_PARTICIPANTS)
    widths = rng.uniform(5, 12, N_PARTICIPANTS)
    guess = FALSE_ALARM_RATE if task == "yes_no" else 0.5
    chance = [
        PsychometricFunction("normal", m, w, guess, LAPSE_RATE).probability(LEVELS)
        for m, w in zip(truth, widths, strict=True)
    ]
    n_catch = 30 if task == "yes_no" else 0
    fits = fit_many(
        LEVELS,
        rng.binomial(n, chance),
        n,
        shape="normal",
        guess_rate=None if task == "yes_no" else 0.5,
        n_false_alarms=rng.binomial(n_catch, guess, N_PARTICIPANTS),
        n_catch=n_catch,
    )
    return truth, fits


def test_mean_bias_is_small_against_participant_spread(recovered) -> None:
    """Bias is below 0.15 SD, plus its standard error at 1e-4."""
    truth, fits = recovered
    errors = np.array([f.threshold - t for f, t in zip(fits, truth, strict=True) if f.threshold is not None])
    assert len(errors) > 0.95 * len(truth)
    assert abs(errors.mean()) < 0.15 * SD_DB + 3.9 * errors.std() / np.sqrt(len(errors))


def test_intervals_cover_the_truth(recovered) -> None:
    """An open end covers all values on its side."""
    truth, fits = recovered
    covered = sum(
        (f.interval_low is None or f.interval_low <= t) and (f.interval_high is None or t <= f.interval_high)
        for f, t in zip(fits, truth, strict=True)
    )
    assert covered >= binom.ppf(RARE, len(truth), COVERAGE)
    assert all(f.interval_low is not None or f.interval_high is not None for f in fits)


def test_intervals_are_not_much_wider_than_errors(recovered) -> None:
    truth, fits = recovered
    told = [(f, t) for f, t in zip(fits, truth, strict=True) if f.status == "ok"]
    half = np.array([(f.interval_high - f.interval_low) / 2 for f, _ in told])
    errors = np.array([f.threshold - t for f, t in told])
    assert half.mean() < 1.4 * 1.96 * errors.std()
