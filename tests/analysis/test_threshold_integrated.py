"""Tests of threshold fits against a probit regression and psignifit 4.3."""

import warnings
from functools import cache

import numpy as np
import pytest
from scipy.special import gammaln, ndtr, xlogy
from soak import SOAK

from tactometry.analysis.threshold.fitting import Status, ThresholdFit, fit, fit_many
from tactometry.psychometric import SHAPES, PsychometricFunction

SEVEN = [1, 2, 3, 4, 5, 6, 7]


def fitted(n_correct, **options) -> ThresholdFit:
    return fit(SEVEN, n_correct, 20, **({"shape": "normal", "guess_rate": 0.5} | options))


def test_equals_a_probit_regression_on_many_random_sets() -> None:
    import statsmodels.api as sm

    rng = np.random.default_rng()
    levels = np.arange(-3.0, 4.0)
    k = rng.binomial(25, 1 / (1 + np.exp(-1.2 * levels + rng.normal(size=(100, 1)))))
    compared = 0
    fits = fit_many(levels, k, 25, shape="normal", guess_rate=0.0, lapse_rate=0.0, method="likelihood")
    probit = sm.families.Binomial(sm.families.links.Probit())
    for counts, found in zip(k, fits, strict=True):
        if found.status != Status.OK:
            continue
        model = sm.GLM(np.column_stack([counts, 25 - counts]), sm.add_constant(levels), family=probit)
        intercept, slope = model.fit(tol=1e-12).params
        assert found.threshold == pytest.approx(-intercept / slope, rel=1e-6, abs=1e-7)
        assert found.width == pytest.approx(SHAPES["normal"].z_width / slope, rel=1e-6)
        compared += 1
    assert compared > 50


def psignifit_log_posterior(data, parameters, threshold_range, smallest_gap) -> float:
    """Return psignifit 4's unnormalised log posterior of two alternatives without overdispersion."""
    from psignifit import _priors, sigmoids

    m, w, lapse = parameters
    levels, k, n = np.array(data, dtype=float).T
    p = 0.5 + (0.5 - lapse) * sigmoids.sigmoid_by_name("norm")(levels, m, w)
    value = np.sum(xlogy(k, p) + xlogy(n - k, 1 - p))
    with np.errstate(divide="ignore"):
        value += np.log(_priors.threshold_prior(np.array([m]), threshold_range))[0]
        value += np.log(_priors.width_prior(np.array([w]), 0.05, smallest_gap, np.ptp(threshold_range)))[0]
    return float(value + np.log(_priors.lambda_prior(np.array([lapse])))[0])


def test_mode_is_more_probable_than_fine_grid() -> None:
    pytest.importorskip("psignifit")
    rng = np.random.default_rng()
    for _ in range(50 if SOAK else 2):
        k = rng.binomial(20, np.array([0.5, 0.55, 0.6, 0.75, 0.9, 0.95, 0.97]))
        found = fitted(k)
        if found.status != Status.OK:
            continue
        data = list(zip(SEVEN, k, [20] * 7, strict=True))
        best = psignifit_log_posterior(data, (found.threshold, found.width, found.lapse_rate), (1, 7), 1)
        for m in np.linspace(0, 8, 13):
            for w in np.geomspace(1.1, 17, 9):
                for lapse in (0.0, 0.01, 0.05, 0.15):
                    assert psignifit_log_posterior(data, (m, w, lapse), (1, 7), 1) <= best + 1e-6


# Integrated: nodes of each parameter with the weights of a quadrature
def equidistant(low, high, n) -> tuple[np.ndarray, np.ndarray]:
    return np.linspace(low, high, n), np.full(n, (high - low) / (n - 1))


def legendre(low, high, n) -> tuple[np.ndarray, np.ndarray]:
    nodes, weights = np.polynomial.legendre.leggauss(n)
    return low + (high - low) * (nodes + 1) / 2, weights * (high - low) / 2


def marginals(k, *, free_guess, overdispersed) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return nodes and masses of threshold and width by psignifit's model."""
    from psignifit import _priors

    fine = not (free_guess or overdispersed)
    m, m_weight = equidistant(-1.99, 9.99, 121 if overdispersed else 361)
    v, v_weight = equidistant(np.log(1.001), np.log(17.99), 121 if fine else 65)
    w = np.exp(v)
    lapse, l_weight = legendre(0, 0.5, 20 if fine else 14)
    guess, g_weight = legendre(0, 0.5, 14) if free_guess else (np.array([0.5]), np.ones(1))
    eta, e_weight = legendre(0, 0.9, 14) if overdispersed else (np.zeros(1), np.ones(1))
    with np.errstate(divide="ignore"):
        prior = np.log(_priors.threshold_prior(m, (1, 7)))[:, None] + np.log(_priors.width_prior(w, 0.05, 1, 6))
    total = prior[..., None, None, None] + 9 * np.log1p(-lapse)[:, None, None] + 9 * np.log1p(-eta)
    total = total + (9 * np.log1p(-guess)[:, None] if free_guess else 0.0)
    for level, count in zip(SEVEN, k, strict=True):
        z = (level - m[:, None]) / w * SHAPES["normal"].z_width
        cdf, sf = ndtr(z)[..., None, None], ndtr(-z)[..., None, None]
        span = 1 - guess - lapse[:, None]
        yes, no = guess + span * cdf, lapse[:, None] + span * sf
        total = total + chance_of(count, yes[..., None], no[..., None], eta)
    mass = np.exp(total - total.max()) * (w * v_weight)[:, None, None, None] * l_weight[:, None, None]
    mass = mass * g_weight[:, None] * e_weight
    curve = mass.sum(axis=(2, 3, 4)) * m_weight[:, None]
    return {"threshold": (m, curve.sum(axis=1)), "width": (v, curve.sum(axis=0))}


def chance_of(k, yes, no, eta) -> np.ndarray:
    """Return the log-likelihood of k of 20 answers, beta-binomial with nu = 1 / eta^2 - 1."""
    if not eta.any():
        return k * np.log(yes) + (20 - k) * np.log(no)
    nu = 1 / eta**2 - 1
    a, b = yes * nu, no * nu
    rising = gammaln(k + a) - gammaln(a) + gammaln(20 - k + b) - gammaln(b)
    return rising - (gammaln(20 + nu) - gammaln(nu))


def ends_of(nodes, masses) -> np.ndarray:
    step = nodes[1] - nodes[0]
    share = np.cumsum(masses) / masses.sum()
    return np.interp([0.025, 0.975], share, nodes + step / 2)


@pytest.mark.parametrize(
    ("free_guess", "overdispersed", "n_sets"),
    [(False, False, 6), (True, False, 1), (False, True, 1)],
    ids=["2AFC", "yes/no", "overdispersed"],
)
def test_means_and_intervals_match_fine_grid_integral(free_guess, overdispersed, n_sets) -> None:
    pytest.importorskip("psignifit")
    rng, compared = np.random.default_rng(), 0
    options = {"guess_rate": None if free_guess else 0.5, "overdispersion": overdispersed, "estimate": "mean"}
    while compared < (100 if SOAK else n_sets):
        guess = rng.uniform(0, 0.1) if free_guess else 0.5
        curve = PsychometricFunction("normal", rng.uniform(3, 5), rng.uniform(2.5, 5), guess, rng.uniform(0, 0.05))
        k = rng.binomial(20, curve.probability(SEVEN))
        found = fitted(k, **options)
        if found.status != Status.OK:
            continue
        compared += 1
        along = marginals(k, free_guess=free_guess, overdispersed=overdispersed)
        ends, widths = ends_of(*along["threshold"]), np.exp(ends_of(*along["width"]))
        nodes, mass = along["threshold"]
        assert [found.interval_low, found.interval_high] == pytest.approx(ends.tolist(), abs=0.01 * np.ptp(ends))
        assert found.threshold == pytest.approx((nodes * mass).sum() / mass.sum(), abs=0.01 * np.ptp(ends))
        assert [found.width_low, found.width_high] == pytest.approx(widths.tolist(), abs=0.01 * np.ptp(widths))
        mean = (np.exp(along["width"][0]) * along["width"][1]).sum() / along["width"][1].sum()
        assert found.width == pytest.approx(mean, abs=0.01 * np.ptp(widths))


N_SETS = 100 if SOAK else 3
LEVELS, N_TRIALS = np.arange(1.0, 8.0), 20


def psignifit(levels, k, n):
    peer = pytest.importorskip("psignifit").psignifit
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return peer(np.column_stack([levels, k, np.full(len(k), n)]), sigmoid="norm", experiment_type="2AFC")


@pytest.mark.slow
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


@pytest.mark.slow
@pytest.mark.parametrize("number", range(11))
def test_overdispersed_estimates_agree_with_psignifit(number) -> None:
    answers = [DOCUMENTED, *few_answers()][number]
    peer = psignifit(*answers)
    found = fit(*answers, shape="normal", guess_rate=0.5, overdispersion=True)
    tolerance = 0.01 * (found.interval_high - found.interval_low)
    assert found.threshold_mode == pytest.approx(peer.parameter_estimate_MAP["threshold"], abs=tolerance)
    assert found.threshold_mean == pytest.approx(peer.parameter_estimate_mean["threshold"], abs=tolerance)
