"""Tests against psignifit 4.3 on random data sets.

The soak uses 100, the reduced form a few.
"""

import warnings
from functools import cache

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from soak import SOAK

from tactometry.analysis.threshold.fitting import Status, fit
from tactometry.psychometric import PsychometricFunction

pytestmark = pytest.mark.slow

N_SETS = 100 if SOAK else 3
LEVELS, N_TRIALS = np.arange(1.0, 8.0), 20
PEER_GRID = 0.025
"""Its grid of 40 x 40 x 20 x 20 nodes moves its ends by 1.4 to 2.5 % of the interval when doubled."""


def ours(k, **options):
    return fit(LEVELS, k, N_TRIALS, shape="normal", guess_rate=0.5, overdispersion=True, **options)


@pytest.fixture(scope="module")
def pairs():
    """Return psignifit's results with our counts; ignore its warnings."""
    psignifit = pytest.importorskip("psignifit").psignifit
    rng, found = np.random.default_rng(), []
    while len(found) < N_SETS:
        curve = PsychometricFunction("normal", rng.uniform(3, 5), rng.uniform(2.5, 5), 0.5, rng.uniform(0, 0.05))
        k = rng.binomial(N_TRIALS, curve.probability(LEVELS))
        if ours(k).status != Status.OK:
            continue
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            data = np.column_stack([LEVELS, k, np.full(7, N_TRIALS)])
            found.append((k, psignifit(data, sigmoid="norm", experiment_type="2AFC")))
    return found


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


def test_mode_is_at_least_as_probable_as_psignifits(pairs) -> None:
    for k, peer in pairs:
        found = ours(k)
        theirs = peer.parameter_estimate_MAP
        at_theirs = log_posterior(k, theirs["threshold"], theirs["width"], theirs["lambda"], theirs["eta"])
        at_ours = log_posterior(k, found.threshold, found.width, found.lapse_rate, found.overdispersion)
        assert at_ours >= at_theirs - 1e-6


def test_intervals_match_integrated_psignifit_marginals(pairs) -> None:
    errors, printed = [], []
    for k, peer in pairs:
        found = ours(k)
        nodes, density = peer.parameter_values["threshold"], peer.marginal_posterior_values["threshold"]
        fine = np.linspace(nodes[0], nodes[-1], 4001)
        integral = CubicSpline(nodes, density).antiderivative()(fine)
        ends = np.interp([0.025, 0.975], integral / integral[-1], fine)
        errors.append((np.array([found.interval_low, found.interval_high]) - ends) / np.ptp(ends))
        printed.append((ends - np.array(peer.confidence_intervals["threshold"]["0.95"])) / np.ptp(ends))
    assert np.abs(errors).max() < 3 * PEER_GRID
    assert np.abs(np.median(errors, axis=0)).max() < 1.5 * PEER_GRID
    assert np.mean(printed) > 0.01


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
    levels, k, n = [DOCUMENTED, *few_answers()][number]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        data = np.column_stack([levels, k, np.full(len(k), n)])
        peer = pytest.importorskip("psignifit").psignifit(data, sigmoid="norm", experiment_type="2AFC")
    found = fit(levels, k, n, shape="normal", guess_rate=0.5, overdispersion=True)
    errors = [
        found.threshold_mode - peer.parameter_estimate_MAP["threshold"],
        found.threshold_mean - peer.parameter_estimate_mean["threshold"],
    ]
    assert np.abs(errors).max() < 0.01 * (found.interval_high - found.interval_low)
