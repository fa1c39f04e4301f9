"""Tests of beta-binomial fits: published values and derivatives."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from matlab_cases import MATLAB, matlab_case
from scipy.stats import betabinom, binom

from tactometry.analysis.threshold.counts import normalise
from tactometry.analysis.threshold.fitting import METHODS, fit
from tactometry.analysis.threshold.likelihood import expansion, log_weight, overdispersed_expansion
from tactometry.psychometric import SHAPES, PsychometricFunction


def test_chance_and_variance_of_the_published_example() -> None:
    """Science 11.4, exact."""
    k = np.arange(21)
    weights = np.array([log_weight(np.array(0.75), np.array(0.25), int(i), 20, 0.2) for i in k])
    chances = np.exp(weights) * binom.pmf(k, 20, 0.5) * 2.0**20
    assert chances[15] == pytest.approx(0.148414569, abs=5e-10)
    assert chances.sum() == pytest.approx(1.0, rel=1e-12)
    assert (chances * (k - 15) ** 2).sum() == pytest.approx(6.6, rel=1e-10)


@given(p=st.floats(0.01, 0.99), eta=st.floats(0.01, 0.95), n=st.integers(1, 60), data=st.data())
@settings(deadline=None)
def test_equals_scipys_beta_binomial(p: float, eta: float, n: int, data: st.DataObject) -> None:
    k, nu = data.draw(st.integers(0, n)), 1 / eta**2 - 1
    peer = betabinom.logpmf(k, n, nu * p, nu * (1 - p)) - binom.logpmf(k, n, 0.5) - n * np.log(2)
    assert log_weight(np.array(p), np.array(1 - p), k, n, eta) == pytest.approx(peer, rel=1e-9, abs=1e-8)


@pytest.mark.parametrize("shape", list(SHAPES))
@pytest.mark.parametrize("eta", [0.05, 0.3])
def test_gradient_and_curvature_are_derivatives(shape: str, eta: float) -> None:
    k = np.random.default_rng().binomial(20, 0.7, (1, 7)).astype(float)
    counts, etas = normalise(np.arange(7.0)[None], k, np.full((1, 7), 20.0)), np.array([eta])
    theta, h = np.array([[0.1, -0.5, 0.03, 0.1]]), 1e-5
    here = overdispersed_expansion(SHAPES[shape], counts, theta, etas)
    for place, step in enumerate(np.eye(4) * h):
        up, down = (overdispersed_expansion(SHAPES[shape], counts, theta + s, etas) for s in (step, -step))
        assert here.gradient[0, place] == pytest.approx((up.value - down.value)[0] / (2 * h), rel=1e-4, abs=1e-3)
        slope = (up.gradient - down.gradient)[0] / (2 * h)
        assert here.hessian[0, place] == pytest.approx(slope, rel=1e-4, abs=1e-2)


def test_little_overdispersion_is_the_binomial() -> None:
    counts = normalise(np.arange(5.0)[None], np.array([[2.0, 4, 9, 12, 19]]), np.full((1, 5), 20.0))
    theta = np.array([[0.1, -0.4, 0.02, 0.05]])
    binomial = expansion(SHAPES["normal"], counts, theta)
    beta = overdispersed_expansion(SHAPES["normal"], counts, theta, np.array([2e-4]))
    assert beta.value == pytest.approx(binomial.value, abs=1e-4)
    assert beta.gradient == pytest.approx(binomial.gradient, rel=1e-3, abs=1e-3)


ONE_EACH = ("M_2AFC_norm", "M_YesNo_logistic")
"""Both tasks; `make check` takes every shape."""


@pytest.mark.parametrize(
    "name", [name if name in ONE_EACH else pytest.param(name, marks=pytest.mark.slow) for name in MATLAB]
)
def test_means_and_intervals_of_matlab_psignifit(name: str) -> None:
    """The error of MATLAB's ends is about 1 % of the width on each side."""
    counts, options, expected = matlab_case(name)
    found = fit(*counts, **options, overdispersion=True, estimate="mean")
    of_threshold, of_width = (found.interval_low, found.interval_high), (found.width_low, found.width_high)
    for ends, key in ((of_threshold, "CI95_threshold"), (of_width, "CI95_width")):
        assert ends == pytest.approx(expected[key], abs=0.02 * np.ptp(expected[key]))
    mean = (found.threshold, found.width, found.lapse_rate, found.guess_rate, found.overdispersion)
    scale = (np.ptp(expected["CI95_threshold"]), np.ptp(expected["CI95_width"]), 0.1, 0.1, 0.1)
    for one, other, size in zip(mean, expected["mean"], scale, strict=True):
        assert one == pytest.approx(other, abs=0.025 * size)


def test_psignifits_interval_of_the_published_set() -> None:
    """Science 11.4: the ends that psignifit 4.3 prints are 2.3 to 5.7 % too low."""
    levels = [0.0010, 0.0015, 0.0020, 0.0025, 0.0030, 0.0035, 0.0040, 0.0045, 0.0050, 0.0060, 0.0070, 0.0080, 0.0100]
    correct = [45, 50, 44, 44, 52, 53, 62, 64, 76, 79, 88, 90, 90]
    found = fit(levels, correct, 90, shape="normal", guess_rate=0.5, overdispersion=True)
    for end, printed in ((found.interval_low, 0.004251), (found.interval_high, 0.004932)):
        assert 0.02 < (end - printed) / (0.004932 - 0.004251) < 0.06


def test_overdispersed_answers_are_seen_and_widen_the_interval() -> None:
    rng = np.random.default_rng()
    levels, eta = np.linspace(-3, 3, 60), 0.35
    p = PsychometricFunction("logistic", 0.0, 3.0, 0.0, 0.0).probability(levels)
    nu = 1 / eta**2 - 1
    k = rng.binomial(60, rng.beta(nu * p, nu * (1 - p)))
    options = {"shape": "logistic", "guess_rate": 0.0, "lapse_rate": 0.0}
    plain, spread = (fit(levels, k, 60, overdispersion=flag, **options) for flag in (False, True))
    assert spread.overdispersion == pytest.approx(eta, abs=0.2)
    assert spread.interval_high - spread.interval_low > 1.3 * (plain.interval_high - plain.interval_low)
    assert plain.overdispersion is None


@pytest.mark.parametrize(
    "k",
    [[11, 12, 8, 13, 15, 19, 18], [12, 9, 11, 14, 18, 18, 19], [8, 6, 10, 13, 19, 19, 20], [7, 8, 13, 11, 18, 18, 19]],
)
def test_mode_without_overdispersion_equals_binomial_mode(k) -> None:
    """The coarse grid leads to a shallow maximum below a steep one."""
    options = {"shape": "normal", "guess_rate": 0.5}
    binomial, found = (fit(np.arange(1.0, 8), k, 20, overdispersion=free, **options) for free in (False, True))
    assert found.overdispersion == 0
    for name in ("threshold", "width", "lapse_rate"):
        assert getattr(found, name) == pytest.approx(getattr(binomial, name), rel=1e-6)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("k", "mode", "median", "mean"),
    [
        ([9, 14, 11, 22, 17, 24], 4.2359, 3.8983, 3.8813),
        ([16, 16, 10, 15, 23, 23], 4.2468, 4.1459, 4.0716),
        ([21, 10, 18, 18, 16, 22], 4.2971, 3.4815, 3.3078),
    ],
)
def test_point_estimates_are_those_of_psignifit(method, k, mode, median, mean) -> None:
    """Compare with psignifit 4.3; the median is from its marginal."""
    found = fit(range(1, 7), k, 24, shape="normal", guess_rate=0.5, overdispersion=True, method=method)
    assert found.threshold_mode == pytest.approx(mode, abs=0.004)
    assert found.threshold_median == pytest.approx(median, abs=0.007)
    assert found.threshold_mean == pytest.approx(mean, abs=0.013)
