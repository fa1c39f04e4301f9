"""Tests of censored pairs and equivalence against tests of known values."""

import numpy as np
import pandas as pd
import pytest
from designs import GIVEN, cut, drawn, long_table, open_ended, study as of_groups

from tactometry.analysis.anova.censored import (
    CensoredAnova,
    censored_anova,
    censored_equivalence,
    censored_group_pairs,
    censored_pairs,
)
from tactometry.analysis.anova.post_hoc import equivalence, pairs
from tactometry.analysis.anova.split_plot import group_pairs

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
