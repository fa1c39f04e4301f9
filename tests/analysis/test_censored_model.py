"""Tests of censored mixed models against exact likelihoods and truths."""

from dataclasses import replace
from itertools import product

import mpmath
import numpy as np
import pandas as pd
import pytest
from hard_cases import exact_case, hard_case
from scipy.optimize import approx_fprime

from tactometry.analysis.mixed_models.censored import (
    LARGEST_STEP,
    Intervals,
    _refuse_endless,
    censored_model,
    endless_direction,
    maximise,
    of_interval,
    of_value,
)
from tactometry.analysis.mixed_models.linear import ModelStatus, mixed_model, model_design
from tactometry.errors import InvalidParameter

GIVEN = {"dependent": "y", "low": "low", "high": "high", "subject": "who"}
CUT = 22.0


def study(rng, n=8, sd=2.0) -> pd.DataFrame:
    """Simulate three conditions with means near 19, 21 and 22.5."""
    means = {0.5: 19.0, 1.0: 21.0, 2.0: 22.5}
    own = rng.normal(0, sd, n)
    rows = [(f"P{p}", x, m + own[p] + rng.normal(0, 0.8)) for p in range(n) for x, m in means.items()]
    return pd.DataFrame(rows, columns=["who", "force_n", "y"]).assign(low=np.nan, high=np.nan)


def cut(table) -> pd.DataFrame:
    """Censor values above `CUT`: they are known only to lie above it."""
    above = table["y"] > CUT
    return table.assign(y=table["y"].where(~above), low=np.where(above, CUT, np.nan))


def fit(table, **options):
    return censored_model(table, **(GIVEN | {"factors": ["force_n"]} | options))


def test_censored_model_equals_reml_on_balanced_design() -> None:
    table = study(np.random.default_rng())
    found, restricted = fit(table), mixed_model(table, dependent="y", factors=["force_n"], subject="who")
    for column in ("estimate", "se", "df", "p", "low", "high"):
        np.testing.assert_allclose(found.coefficients[column], restricted.coefficients[column], rtol=1e-5)
    np.testing.assert_allclose(found.terms["F"], restricted.terms["F"], rtol=1e-5)
    assert found.residual_variance == pytest.approx(restricted.residual_variance, rel=1e-5)
    assert found.participant_variance == pytest.approx(restricted.participant_variance, rel=1e-4, abs=1e-5)
    assert found.n_censored == 0


def test_censored_model_equals_statsmodels_ml_without_bounds() -> None:
    import statsmodels.formula.api as smf

    table = study(np.random.default_rng()).drop(index=[2, 7, 13])
    peer = smf.mixedlm("y ~ C(force_n)", table, groups=table["who"]).fit(reml=False, method="bfgs", gtol=1e-9)
    found, n = fit(table), table["who"].nunique()
    np.testing.assert_allclose(found.coefficients["estimate"], peer.fe_params, rtol=1e-5)
    np.testing.assert_allclose(found.residual_variance * (n - 1) / n, peer.scale, rtol=1e-4)
    np.testing.assert_allclose(found.participant_variance * (n - 1) / n, peer.cov_re.iloc[0, 0], rtol=1e-3)
    assert found.log_likelihood == pytest.approx(peer.llf, rel=1e-8)


def test_censored_likelihood_equals_mpmath_integral() -> None:
    table = study(np.random.default_rng(), n=3)
    table.loc[0, ["y", "low", "high"]] = [np.nan, 18.7, 19.2]
    table.loc[5, ["y", "low"]] = [np.nan, CUT]
    table.loc[7, ["y", "high"]] = [np.nan, 20.0]
    found = fit(table)
    beta = found.coefficients["estimate"].to_numpy()
    sd, own = (float(np.sqrt(v * 2 / 3)) for v in (found.residual_variance, found.participant_variance))
    means = dict(zip((0.5, 1.0, 2.0), beta[0] + np.array([0.0, *beta[1:]]), strict=True))

    def probability_of(row, u):
        mean = means[row.force_n] + own * u
        if not np.isnan(row.y):
            return mpmath.npdf(row.y, mean, sd)
        low, high = (e if np.isnan(v) else v for v, e in ((row.low, -mpmath.inf), (row.high, mpmath.inf)))
        return mpmath.ncdf((high - mean) / sd) - mpmath.ncdf((low - mean) / sd)

    with mpmath.workdps(25):
        total = mpmath.mpf(0)
        for _, part in table.groupby("who"):
            rows = list(part.itertuples())
            integrand = lambda u, rows=rows: mpmath.npdf(u) * mpmath.fprod(probability_of(row, u) for row in rows)  # noqa: E731
            total += mpmath.log(mpmath.quad(integrand, [-9, -4, -1.5, 0, 1.5, 4, 9]))
    hard_case("likelihood of censored values", found.log_likelihood, float(total), 1e-8, against="25 digits")


def test_likelihood_gradient_equals_finite_differences() -> None:
    ends = np.array([[0.3, 0.3], [-0.2, np.inf], [-np.inf, 0.4], [-0.6, 0.1], [-1.1, -1.1]])
    intervals = Intervals.of(ends, np.ones((5, 1)), np.array([0, 0, 1, 1, 2]))
    here, start = np.array([0.1, -0.3, 0.7]), np.zeros(3)
    slope = approx_fprime(here, lambda x: intervals.log_likelihood(x, start)[0])
    np.testing.assert_allclose(intervals.log_likelihood(here, start)[1], slope, rtol=1e-5, atol=1e-6)


ENDS = [(-np.inf, 0.3), (-0.4, np.inf), (-0.4, 0.3), (3.0, 3.1), (-np.inf, -30.0), (30.0, 31.0), (1.1, 1.1)]


@pytest.mark.parametrize("ends", ENDS)
def test_derivatives_of_values_and_intervals_are_exact(ends) -> None:
    def at(x):
        mean, log_sd = np.array(x[0]), np.array(x[1])
        low, high = (np.array(end) for end in ends)
        return of_value(low, mean, log_sd) if low == high else of_interval(low, high, mean, log_sd)

    here, x = at([0.2, -0.3]), np.array([0.2, -0.3])
    gradient = [here.by_mean, here.by_log_sd]
    np.testing.assert_allclose(gradient, approx_fprime(x, lambda x: at(x).value), rtol=1e-5, atol=1e-6)
    ahead, behind = (at([0.2 + step, -0.3]).by_mean for step in (1e-5, -1e-5))
    np.testing.assert_allclose(here.curvature, (ahead - behind) / 2e-5, rtol=1e-5)


def test_tail_interval_log_probability_matches_50_digits() -> None:
    with mpmath.workdps(50):
        exact = float(mpmath.log(mpmath.ncdf(-60) - mpmath.ncdf(-61)))
    for low, high in ((60.0, 61.0), (-61.0, -60.0)):
        found = of_interval(np.array(low), np.array(high), np.array(0.0), np.array(0.0)).value
        hard_case("log chance 60 standard deviations away", found, exact, 1e-12, against="50 digits")


@pytest.mark.parametrize("end", [1e5, 1e7, 1e9])
def test_log_likelihood_curvature_is_not_positive_far_away(end) -> None:
    """Regression test: rounding took all digits of the curvature."""
    for low, high in ((end, np.inf), (-np.inf, -end)):
        assert of_interval(np.array(low), np.array(high), np.array(0.0), np.array(0.0)).curvature <= 0


def test_fit_with_rising_likelihood_is_rejected() -> None:
    table = study(np.random.default_rng())
    matrix = model_design(table, "y", ["force_n"], [], "who", interactions=False, base={})
    ends = np.repeat((table[["y"]] - table["y"].mean()).to_numpy() / table["y"].std(), 2, axis=1)
    found = maximise(Intervals.of(ends, matrix.x, matrix.groups))
    _refuse_endless(found, matrix)
    error = np.sqrt(np.diagonal(found.covariance)[: len(matrix.names)]).max()
    with pytest.raises(InvalidParameter, match="a likelihood that still rises"):
        _refuse_endless(replace(found, gradient=1.01 * LARGEST_STEP / error), matrix)


def test_narrow_interval_counts_as_its_value() -> None:
    table = study(np.random.default_rng())
    whole = fit(table)
    some = table["who"].isin(["P1", "P2"])
    bounds = {"y": table["y"].where(~some), "low": table["y"] - 1e-9, "high": table["y"] + 1e-9}
    narrow = fit(table.assign(**bounds))
    estimates = narrow.coefficients["estimate"], whole.coefficients["estimate"]
    hard_case("values censored to 1e-9 of themselves", *estimates, 1e-6, against="the values")
    assert narrow.n_censored == 0


def test_interval_counts_as_censored_above_minimum_width() -> None:
    for width, n in ((0.05, 1), (1.1e-6, 1), (0.9e-6, 0)):
        laid = Intervals.of(np.array([[1.0, 1.0], [2.0, 2.0 + width]]), np.ones((2, 1)), np.array([0, 0]))
        assert laid.n_censored == n


def test_censored_model_is_symmetric_and_scales_with_units() -> None:
    table = cut(study(np.random.default_rng()))
    above = fit(table)
    below = fit(table.assign(y=-1e-9 * table["y"], low=np.nan, high=-1e-9 * table["low"]))
    estimates = below.coefficients["estimate"] * -1e9, above.coefficients["estimate"]
    hard_case("censored values of 1e-9, mirrored", *estimates, 1e-5, against="those of 1")
    np.testing.assert_allclose(below.coefficients["se"] * 1e9, above.coefficients["se"], rtol=1e-4)
    assert below.residual_variance * 1e18 == pytest.approx(above.residual_variance, rel=1e-4)
    assert below.n_censored == above.n_censored == table["y"].isna().sum()


def test_censored_model_recovers_mean_above_bound() -> None:
    """Half of the values of the third condition are censored."""
    table = cut(study(np.random.default_rng(), n=60))
    estimate, error = fit(table).coefficients.loc[2, ["estimate", "se"]]
    known = mixed_model(table.dropna(subset="y"), dependent="y", factors=["force_n"], subject="who")
    assert abs(estimate - 3.5) < 4.1 * error
    assert known.coefficients["estimate"][2] < estimate


def test_censored_model_is_singular_for_identical_participants() -> None:
    y = np.array([[1.0, 4.0, 2.5], [2.0, 3.0, 3.6], [3.1, 2.0, 4.0], [0.5, 2.9, 3.0]])
    y = y - y.mean(axis=1, keepdims=True)
    rows = [(f"P{p}", x, y[p, c]) for p in range(4) for c, x in enumerate((0.5, 1.0, 2.0))]
    table = pd.DataFrame(rows, columns=["who", "force_n", "y"]).assign(low=np.nan, high=np.nan)
    found = fit(table)
    assert (found.status, found.participant_variance) == (ModelStatus.SINGULAR, 0.0)
    assert "a singular but valid fit" in found.notes[0]
    exact_case("a censored model of identical participants", against="a status")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"y": np.nan, "low": np.nan}, "y, row 0: found neither a value nor a bound, expected a value, or a"),
        ({"y": np.inf}, "y, row 0: found the bounds inf and inf"),
        ({"y": np.nan, "low": 3.0, "high": 2.0}, "y, row 0: found the bounds 3 and 2"),
        ({"low": [None, "few", *[None] * 22]}, "low, row 1: found few, expected a number or nothing"),
    ],
)
def test_censored_model_rejects_invalid_bounds(change, message) -> None:
    with pytest.raises(InvalidParameter, match=message):
        fit(cut(study(np.random.default_rng())).assign(**change))


def test_censored_model_rejects_endless_likelihood_and_unknown_column() -> None:
    table = cut(study(np.random.default_rng()))
    endless = table["force_n"] == 2.0
    with pytest.raises(InvalidParameter, match=r"force_n = 2.0: found a likelihood without a finite maximum"):
        fit(table.assign(y=table["y"].where(~endless), low=table["low"].where(~endless, 22.0)))
    with pytest.raises(InvalidParameter, match="found no column 'lows'; did you mean 'low'"):
        fit(table, low="lows")


@pytest.mark.parametrize(
    ("ends", "direction"),
    [
        ([(1, 1), (2, 2), (3, np.inf), (2, 2)], None),
        ([(1, 1), (2, 2), (3, np.inf), (2, np.inf)], [0, 1]),
        ([(1, 1), (2, 2), (3, np.inf), (-np.inf, 9)], None),
        ([(1, 1), (2, 2), (-np.inf, 3), (-np.inf, 4)], [0, -1]),
        ([(1, 1), (2, 2), (3, 4), (3, np.inf)], None),
        ([(1, 1), (2, 2), (-np.inf, np.inf), (-np.inf, np.inf)], None),
    ],
)
def test_unbounded_coefficient_is_detected_before_search(ends, direction) -> None:
    found = endless_direction(np.array(ends, dtype=float), np.array([[1.0, 0], [1, 0], [1, 1], [1, 1]]))
    assert (None if found is None else np.sign(found).tolist()) == direction


def test_known_values_without_error_are_rejected_before_search() -> None:
    table = study(np.random.default_rng())
    known = (table["who"] == "P0") & (table["force_n"] < 2)
    with pytest.raises(InvalidParameter, match="known values that terms and participants explain exactly"):
        fit(table.assign(y=table["y"].where(known), low=18.0, high=25.0))


def test_censored_model_fits_or_rejects_small_tables() -> None:
    """Regression test: searches took half a minute or failed within scipy."""
    rng = np.random.default_rng()
    for n, sd, share in product((2, 4), (1e-9, 1.0), (0.1, 0.5)):
        table = study(rng, n, sd)
        above = table["y"] > table["y"].quantile(1 - share)
        try:
            found = fit(table.assign(y=table["y"].where(~above), low=table["y"][above].min()))
            assert np.isfinite(found.coefficients["estimate"]).all()
        except InvalidParameter:
            pass


def test_empty_slots_add_nothing_to_likelihood() -> None:
    laid = Intervals.of(np.array([[1.0, 1], [2, 3], [0, 0]]), np.ones((3, 1)), np.array([0, 0, 1]))
    at = laid.values(np.zeros((2, 2)), np.zeros(()))
    assert (laid.n_censored, at.value[1, 1]) == (1, 0.0)
    assert not at.by_mean[1, 1].any()
    assert not at.curvature[1, 1].any()
