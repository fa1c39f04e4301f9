"""Tests of distributions against scipy."""

import numpy as np
import pytest
from scipy import stats

from tactometry.analysis.distributions import ChiSquare, Fisher, Student

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
