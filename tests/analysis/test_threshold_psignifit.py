"""Tests against psignifit 4.3 on random data sets (100 in the soak)."""

import warnings
from functools import cache

import numpy as np
import pytest
from soak import SOAK

from tactometry.analysis.threshold.fitting import Status, fit
from tactometry.psychometric import PsychometricFunction

pytestmark = pytest.mark.slow

N_SETS = 100 if SOAK else 3
LEVELS, N_TRIALS = np.arange(1.0, 8.0), 20


def psignifit(levels, k, n):
    peer = pytest.importorskip("psignifit").psignifit
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return peer(np.column_stack([levels, k, np.full(len(k), n)]), sigmoid="norm", experiment_type="2AFC")


def test_mode_is_at_least_as_probable_as_psignifits() -> None:
    rng, n_compared = np.random.default_rng(), 0
    while n_compared < N_SETS:
        curve = PsychometricFunction("normal", rng.uniform(3, 5), rng.uniform(2.5, 5), 0.5, rng.uniform(0, 0.05))
        k = rng.binomial(N_TRIALS, curve.probability(LEVELS))
        found = fit(LEVELS, k, N_TRIALS, shape="normal", guess_rate=0.5, overdispersion=True)
        if found.status == Status.OK:
            theirs = psignifit(LEVELS, k, N_TRIALS).parameter_estimate_MAP
            at_theirs = log_posterior(k, theirs["threshold"], theirs["width"], theirs["lambda"], theirs["eta"])
            at_ours = log_posterior(k, found.threshold, found.width, found.lapse_rate, found.overdispersion)
            assert at_ours >= at_theirs - 1e-6
            n_compared += 1


def log_posterior(k, threshold, width, lapse, eta) -> float:
    """Return the log posterior of psignifit's model, written out."""
    from psignifit import _priors, sigmoids

    p = 0.5 + (0.5 - lapse) * sigmoids.sigmoid_by_name("norm")(LEVELS, threshold, width)
    step = eta**2 / (1 - eta**2)  # rising factorials over nu: no cancellation, and the binomial at eta = 0
    value = -len(LEVELS) * np.log1p(step * np.arange(N_TRIALS)).sum()
    for count, chance in zip([*k, *(N_TRIALS - k)], [*p, *(1 - p)], strict=True):
        value += np.log(chance + step * np.arange(count)).sum()
    value += np.log(_priors.threshold_prior(np.array([threshold]), (1, 7)))[0]
    value += np.log(_priors.width_prior(np.array([width]), 0.05, 1, 6))[0]
    return float(value + 9 * np.log1p(-lapse) + 9 * np.log1p(-eta))


DOCUMENTED = (
    [0.0010, 0.0015, 0.0020, 0.0025, 0.0030, 0.0035, 0.0040, 0.0045, 0.0050, 0.0060, 0.0070, 0.0080, 0.0100],
    [45, 50, 44, 44, 52, 53, 62, 64, 76, 79, 88, 90, 90],
    90,
)
"""The example of its documentation."""


@cache
def few_answers():
    """Draw ten small sets of overdispersed answers with a threshold."""
    rng, found = np.random.default_rng(20), []
    while len(found) < 10:
        curve = PsychometricFunction("normal", rng.uniform(2.5, 4.5), rng.uniform(2.5, 5), 0.5, rng.uniform(0, 0.05))
        p, nu = curve.probability(LEVELS[:6]), 1 / rng.choice([0.05, 0.15, 0.25]) ** 2 - 1
        k = rng.binomial(24, rng.beta(nu * p, nu * (1 - p)))
        if fit(LEVELS[:6], k, 24, shape="normal", guess_rate=0.5).status == Status.OK:
            found.append((LEVELS[:6], k, 24))
    return found


@pytest.mark.parametrize("number", range(11))
def test_overdispersed_estimates_agree_with_psignifit(number) -> None:
    answers = [DOCUMENTED, *few_answers()][number]
    peer = psignifit(*answers)
    found = fit(*answers, shape="normal", guess_rate=0.5, overdispersion=True)
    tolerance = 0.01 * (found.interval_high - found.interval_low)
    assert found.threshold_mode == pytest.approx(peer.parameter_estimate_MAP["threshold"], abs=tolerance)
    assert found.threshold_mean == pytest.approx(peer.parameter_estimate_mean["threshold"], abs=tolerance)
