"""Tests of ANOVA with bounds against ANOVA, integrals and truths."""

import re
from itertools import product

import mpmath
import numpy as np
import pandas as pd
import pytest
from designs import GIVEN, NAMES, cut, drawn, long_table, open_ended, study as of_groups
from hard_cases import exact_case, hard_case
from scipy.integrate import dblquad
from scipy.stats import multivariate_normal

from tactometry.analysis.anova.bounded_fit import BoundedValues, fit_bounded, truncated_normal
from tactometry.analysis.anova.censored import (
    CensoredAnova,
    censored_anova,
    censored_equivalence,
    censored_group_pairs,
    censored_pairs,
)
from tactometry.analysis.anova.design import DesignStatus, UndefinedStatistic
from tactometry.analysis.anova.group_means import group_table
from tactometry.analysis.anova.post_hoc import equivalence, pairs
from tactometry.analysis.anova.split_plot import group_pairs, mixed_anova
from tactometry.analysis.anova.within_subjects import repeated_measures
from tactometry.analysis.mixed_models.censored import censored_model
from tactometry.errors import InvalidParameter

MAUCHLY = ("W_spher", "p_spher", "sphericity")


def alike(found: pd.DataFrame, peer: pd.DataFrame) -> None:
    assert list(found.columns) == list(peer.columns)
    for name in set(peer.columns) - {"Source", *MAUCHLY}:
        expected = pytest.approx(peer[name].to_numpy(dtype=float), rel=1e-6, abs=1e-9, nan_ok=True)
        assert found[name].to_numpy(dtype=float) == expected, name


@pytest.mark.parametrize("shape", [(5, 2), (8, 4), (6, 3, 4), (5, 2, 3, 2)])
def test_censored_anova_equals_anova_without_bounds(shape) -> None:
    """Every column except Mauchly's test agrees, at any scale."""
    table = long_table(drawn(shape, np.random.default_rng()))
    within = NAMES[: len(shape) - 1]
    peer = repeated_measures(table, dependent="y", within=within, subject="subject")
    alike(censored_anova(open_ended(table), within=within, **GIVEN).table, peer)
    large = censored_anova(open_ended(table.assign(y=1e300 * table["y"])), within=within, **GIVEN).table
    hard_case("censored ANOVA of values of 1e300: F", large["F"].dropna(), peer["F"].dropna(), 1e-6, against="ANOVA")


@pytest.mark.parametrize("sizes", [(6, 6), (4, 7, 5)])
def test_censored_anova_equals_mixed_anova_without_bounds(sizes) -> None:
    table = of_groups(sizes, 6, np.random.default_rng())
    crossed = table.assign(force=table["freq"] // 3, freq=table["freq"] % 3)
    within = ["force", "freq"]
    peer = mixed_anova(crossed, dependent="y", within=within, between="hand", subject="subject")
    found = censored_anova(open_ended(crossed), within=within, between="hand", **GIVEN)
    alike(found.table, peer)
    assert found.means()["hand"].nunique() == len(sizes)


def test_censored_means_equal_group_table_without_bounds() -> None:
    table = long_table(drawn((7, 3, 2), np.random.default_rng())).rename(columns={"subject": "participant"})
    found = censored_anova(open_ended(table), within=NAMES[:2], **(GIVEN | {"subject": "participant"})).means()
    peer = group_table(table.assign(status="ok"), NAMES[:2], "y")
    assert found[[*NAMES[:2]]].to_numpy().tolist() == peer[[*NAMES[:2]]].to_numpy().tolist()
    for name in ("mean", "mean_low", "mean_high", "sd"):
        assert found[name].to_numpy() == pytest.approx(peer[name].to_numpy(dtype=float), rel=1e-9)


def test_censored_anova_with_one_factor_equals_censored_model() -> None:
    """The censored model integrates over one random effect by quadrature."""
    rng = np.random.default_rng()
    table = cut(long_table(8 + rng.normal(size=(10, 4)) + 2 * rng.normal(size=(10, 1))), 6.0)
    found = censored_anova(table, within="force", **GIVEN)
    peer = censored_model(table, factors=["force"], **GIVEN)
    first, *others = peer.coefficients["estimate"]
    sd = np.sqrt(peer.residual_variance)
    means = found.means()["mean"].to_numpy()
    if not peer.notes:
        expected = (first + np.array([0, *others])) / sd
        hard_case("means of conditions with bounds", means / sd, expected, 0.02, against="quadrature")
        assert found.table.loc[0, "F"] == pytest.approx(peer.terms.loc[0, "F"], rel=0.05)
    assert found.design.n_censored == peer.n_censored == table["y"].isna().sum()


def test_censored_likelihood_equals_numerical_integral() -> None:
    rng = np.random.default_rng()
    y = rng.normal(size=(4, 4)) + rng.normal(size=(4, 1))
    low, high = y.copy(), y.copy()
    low[0, 1], high[0, 2] = -np.inf, np.inf
    fit = fit_bounded(BoundedValues(low, high, np.zeros(4, dtype=np.int64), (2, 2)))
    density = multivariate_normal(fit.means[0], fit.model)
    (first, below, above, last), far = y[0], 12 * np.sqrt(fit.model[0, 0])
    chance = dblquad(
        lambda b, a: density.pdf([first, a, b, last]), below - far, below, above, above + far, epsabs=1e-13, epsrel=1e-8
    )[0]
    total = float(np.sum(density.logpdf(y[1:]))) + np.log(chance)
    hard_case("likelihood of two bounds of one participant", fit.log_likelihood, total, 1e-3, against="an integral")


@pytest.mark.parametrize(("low", "high"), [(-np.inf, -1.0), (0.5, np.inf), (-0.3, 0.4), (3.0, np.inf), (30.0, 31.0)])
def test_truncated_normal_points_have_exact_moments(low, high) -> None:
    from scipy.stats import truncnorm

    found = truncated_normal(np.zeros(1), np.eye(1), np.array([low]), np.array([high]))
    peer = truncnorm(low, high)
    assert found.log_probability == pytest.approx(float(peer.logcdf(high) + _log_mass(low, high)), abs=1e-9)
    mean = float(found.weights @ found.values[:, 0])
    assert mean == pytest.approx(float(peer.mean()), abs=5e-3 * float(peer.std()))
    assert ((low <= found.values) & (found.values <= high)).all()


def _log_mass(low: float, high: float) -> float:
    low, high = (-high, -low) if low > 0 else (low, high)
    with mpmath.workdps(40):
        return float(mpmath.log(mpmath.ncdf(high) - mpmath.ncdf(low)))


def test_truncated_normal_points_change_continuously_with_bound() -> None:
    """Regression test: points jumped as a bound passed the mean, and the search did not converge."""
    covariance, ends = np.array([[1.0, 0.5], [0.5, 1.0]]), (np.zeros(2), np.full(2, np.inf))
    one, other = (truncated_normal(np.full(2, x), covariance, *ends).values for x in (-1e-6, 1e-6))
    assert np.abs(one - other).max() < 1e-4


def test_censored_anova_converges_on_small_studies() -> None:
    rng = np.random.default_rng()
    for _ in range(5):
        table = pd.DataFrame(list(product("abcdef", (1, 2), (1, 2))), columns=["subject", "f", "g"])
        table["y"] = rng.normal(size=6).repeat(4) + rng.normal(size=24)
        table.loc[[0, 1, 6], "y"] = np.nan
        found = censored_anova(table.assign(low=table["y"].mean(), high=np.nan), within=["f", "g"], **GIVEN)
        assert (found.design.n_censored, found.fit.converged) == (3, True)


def test_censored_anova_ignores_unit_offset_and_sign() -> None:
    values = long_table(drawn((9, 3), np.random.default_rng()))
    table = cut(values, float(values["y"].quantile(0.15)))
    one = censored_anova(table, within="force", **GIVEN)
    moved = table.assign(y=-1e-9 * table["y"] + 7e-9, low=-1e-9 * table["high"] + 7e-9, high=np.nan)
    other = censored_anova(moved, within="force", **GIVEN)
    assert other.table["F"][0] == pytest.approx(one.table["F"][0], rel=1e-2)
    assert other.means()["mean"].to_numpy() == pytest.approx(-1e-9 * one.means()["mean"].to_numpy() + 7e-9, rel=1e-2)


def test_missing_value_is_not_counted_as_bound() -> None:
    table = open_ended(long_table(drawn((9, 4), np.random.default_rng())))
    holed = table.assign(y=table["y"].where(table.index != 5))
    found = censored_anova(holed, within="force", **GIVEN)
    assert (found.design.n_missing, found.design.n_censored) == (1, 0)
    assert censored_anova(holed.drop(index=5), within="force", **GIVEN).table["F"][0] == found.table["F"][0]
    assert 3 * 7 < found.table.loc[0, "ddof2"] < 3 * 8


def refused(table: pd.DataFrame, message: str, status: DesignStatus | None = None, **options) -> None:
    with pytest.raises(UndefinedStatistic if status else InvalidParameter, match=f"^{re.escape(message)}") as refusal:
        censored_anova(table, **(GIVEN | {"within": "force"} | options))
    assert getattr(refusal.value, "status", None) == status


def test_unanswerable_designs_are_rejected() -> None:
    table = cut(long_table(drawn((8, 3), np.random.default_rng())), -9.0)
    first = table["force"] == 0
    bound = table.assign(y=table["y"].where(~first | (table["subject"] == 3)), high=table["high"].where(~first, 9.0))
    one_known = "force = 0: found 1 known value, expected at least 2 in addition to bounds; remove this condition"
    refused(bound, one_known, DesignStatus.TOO_FEW_KNOWN)
    refused(table[table["subject"] < 2], "subject: found 2 participants", DesignStatus.TOO_FEW_PARTICIPANTS)
    refused(table[first], "force: found 1 value, expected at least 2", DesignStatus.ONE_LEVEL)
    refused(table.assign(y=3.0), "y: found the same value everywhere", DesignStatus.CONSTANT)
    refused(table.iloc[:0], "table: found no row", DesignStatus.NO_DATA)
    unnamed = table.assign(force=table["force"].where(table.index != 4))
    refused(unnamed, "force, row 4: found nothing", DesignStatus.NO_NAME)
    refused(pd.concat([table, table.iloc[:1]]), "subject = 0.0, force = 0.0: found 2 values, expected one in each cell")
    refused(table.assign(y="much"), "y, row 0: found much, expected a number or nothing")
    refused(table.assign(y=np.nan, low=2.0, high=1.0), "y, row 0: found the bounds 2 and 1")
    refused(table.assign(y=np.inf), "y, row 0: found the bounds inf and inf")
    refused(table, "censored_anova: found no column 'forze'; did you mean 'force'?", within=["forze"])
    refused(table, "within: found force, force, expected up to 3 different factors", within=["force", "force"])
    exact_case("bounds without known values beside them: ANOVA", against="one sentence")


@pytest.mark.parametrize("seed", range(5))
def test_an_effect_without_error_has_no_f(seed) -> None:
    rng = np.random.default_rng(seed)
    values = np.arange(6.0)[:, None, None] + np.array([0.0, 3.0])[None, :, None] + rng.normal(size=(6, 1, 3))
    found = censored_anova(open_ended(long_table(values)), within=["force", "freq"], **GIVEN).table
    assert found["F"].isna().tolist() == [True, False, True]
    assert found["ddof2"].tolist() == pytest.approx([5, 10, 10])


def test_effect_is_refused_below_one_degree_of_freedom() -> None:
    # One participant is known in both conditions; three values are missing, four have an upper bound.
    known = [None, 1.10, 2.84, 0.51, None, None, None, 0.48, None, None, 2.30, None]
    bounds = [None, None, None, None, None, 0.57, 2.77, None, None, 0.83, None, 0.47]
    table = pd.DataFrame({"who": list("aabbccddeeff"), "force_n": [1, 2] * 6, "y": known, "high": bounds, "low": None})
    with pytest.raises(UndefinedStatistic, match="degrees of freedom") as refusal:
        censored_anova(table, dependent="y", low="low", high="high", within="force_n", subject="who")
    assert refusal.value.status is DesignStatus.NO_MAXIMUM


COMPARED = ["difference", "difference_low", "simultaneous_high", "t", "df", "p_unc", "p_corr"]


def two_factors() -> tuple[pd.DataFrame, CensoredAnova]:
    table = long_table(drawn((7, 3, 2), np.random.default_rng()))
    return table, censored_anova(open_ended(table), within=["force", "freq"], **GIVEN)


@pytest.mark.parametrize(("factor", "by"), [("force", None), ("freq", None), ("force", "freq"), ("freq", "force")])
def test_censored_pairs_equal_paired_t_tests_without_bounds(factor, by) -> None:
    table, found = two_factors()
    peer = pairs(table, dependent="y", factor=factor, by=by, subject="subject")
    own = censored_pairs(found, factor, by=by)
    keys = [*([by] if by else []), "a", "b"]
    table = own.set_index(keys).loc[peer.set_index(keys).index]
    for name in [*COMPARED, "dz"]:
        assert table[name].to_numpy(dtype=float) == pytest.approx(peer[name].to_numpy(dtype=float), rel=1e-6)


@pytest.mark.parametrize("by", [None, "freq"])
def test_censored_group_pairs_equal_welch_without_bounds(by) -> None:
    table = of_groups((5, 8, 6), 3, np.random.default_rng())
    found = censored_anova(open_ended(table), within="freq", between="hand", **GIVEN)
    own = censored_group_pairs(found, by=by)
    peer = group_pairs(table, dependent="y", between="hand", subject="subject", by=by)
    for name in [*COMPARED, "g", "n_a", "n_b"]:
        assert own[name].to_numpy(dtype=float) == pytest.approx(peer[name].to_numpy(dtype=float), rel=1e-6)


def test_censored_equivalence_equals_equivalence_without_bounds() -> None:
    table, found = two_factors()
    own = censored_equivalence(found, "force", bound=2.0)
    peer = equivalence(table, dependent="y", factor="force", subject="subject", bound=2.0)
    for name in ("difference", "low", "high", "t_low", "p"):
        assert own[name].to_numpy() == pytest.approx(peer[name].to_numpy(), rel=1e-6)
    assert own.attrs["p_all"] == pytest.approx(peer.attrs["p_all"], rel=1e-6)


def test_bounds_cost_degrees_of_freedom_and_width() -> None:
    rng = np.random.default_rng()
    table = long_table(rng.normal(size=(12, 3)) + rng.normal(size=(12, 1)))
    known = censored_pairs(censored_anova(open_ended(table), within="force", **GIVEN), "force")
    bounds = censored_pairs(censored_anova(cut(table, -1.0), within="force", **GIVEN), "force")
    assert (bounds["df"] < known["df"]).all()
    assert known["df"].to_numpy() == pytest.approx(11)
    assert bounds["status"].tolist() == ["ok"] * 3
    assert bounds["bf10"].isna().all()


def test_pair_with_zero_error_has_no_test() -> None:
    rng = np.random.default_rng()
    values = rng.normal(size=(6, 1)) + np.array([0.0, 2.0, 0.0]) + np.array([0, 0, 1]) * rng.normal(size=(6, 1))
    found = censored_pairs(censored_anova(open_ended(long_table(values)), within="force", **GIVEN), "force")
    assert found["status"].tolist() == ["zero_error", "ok", "ok"]
    assert found["difference"][0] == pytest.approx(2.0)
    assert found.loc[0, ["t", "p_corr"]].isna().all()
