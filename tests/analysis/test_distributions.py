"""Tests of distributions, splines and rising fits against scipy."""

import numpy as np
import pytest
from scipy import stats
from scipy.interpolate import CubicSpline
from scipy.optimize import isotonic_regression

from tactometry.analysis.distributions import ChiSquare, Fisher, Student
from tactometry.analysis.threshold.posterior import spline_integral
from tactometry.analysis.threshold.status import rising_fit

DF = np.array([0.3, 1, 2.5, 7, 60, 1e4, 3])
X = np.array([-2.0, -0.5, 0, 0.7, 1.96, 40, np.nan])
P = np.array([1e-12, 0.01, 0.025, 0.3, 0.5, 0.975, np.nan])


@pytest.mark.parametrize(
    ("ours", "theirs", "values", "df"),
    [
        (Student.cdf, stats.t.cdf, X, (DF,)),
        (Student.sf, stats.t.sf, X, (DF,)),
        (Student.ppf, stats.t.ppf, P, (DF,)),
        (Student.isf, stats.t.isf, P, (np.inf,)),
        (Fisher.sf, stats.f.sf, X, (DF, DF + 1)),
        (Fisher.ppf, stats.f.ppf, P, (DF, DF + 1)),
        (ChiSquare.sf, stats.chi2.sf, X, (DF,)),
        (ChiSquare.ppf, stats.chi2.ppf, P, (DF,)),
        (ChiSquare.isf, stats.chi2.isf, P, (3,)),
    ],
)
def test_distributions_equal_those_of_scipy_stats(ours, theirs, values, df) -> None:  # type: ignore[no-untyped-def]
    np.testing.assert_array_equal(ours(values, *df), theirs(values, *df))


@pytest.mark.parametrize("n_nodes", [4, 27, 37])
def test_spline_integral_equals_scipy(n_nodes: int) -> None:
    values = np.random.default_rng(1).random((3, n_nodes))
    places, weights = spline_integral(n_nodes)
    theirs = CubicSpline(np.arange(n_nodes), values, axis=1).antiderivative()(places)
    np.testing.assert_allclose(values @ weights, theirs, rtol=0, atol=1e-13 * n_nodes)


@pytest.mark.parametrize("seed", range(20))
def test_rising_fit_equals_scipy(seed: int) -> None:
    rng = np.random.default_rng(seed)
    weights = rng.integers(1, 9, 10).astype(float)
    values = rng.integers(0, 9, 10) / weights
    np.testing.assert_allclose(rising_fit(values, weights), isotonic_regression(values, weights=weights).x, rtol=1e-13)
