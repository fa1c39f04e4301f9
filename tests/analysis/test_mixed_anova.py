"""Tests of mixed ANOVA against pingouin and regression."""

import warnings

import numpy as np
import pandas as pd
import pytest
from grouped_design import study
from hard_cases import exact_case, hard_case

from tactometry.analysis.anova.design import DesignStatus, UndefinedStatistic
from tactometry.analysis.anova.split_plot import group_pairs, mixed_anova
from tactometry.analysis.anova.within_subjects import repeated_measures
from tactometry.analysis.outcomes.outcome import outcome
from tactometry.analysis.report.sentences import outcome_sentences
from tactometry.errors import InvalidParameter


def analysed(table, within="freq") -> pd.DataFrame:
    found = mixed_anova(table, dependent="y", within=within, between="hand", subject="subject")
    return found.set_index("Source")


@pytest.mark.parametrize(("sizes", "k"), [((6, 6), 3), ((5, 5, 5), 4), ((4, 4), 2)])
def test_groups_of_equal_size_equal_pingouin(sizes, k) -> None:
    import pingouin

    table = study(sizes, k, np.random.default_rng())
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        peer = pingouin.mixed_anova(
            table, dv="y", within="freq", between="hand", subject="subject", correction=True, effsize="ng2"
        )
    found = analysed(table)
    for name, theirs in (("F", "F"), ("SS", "SS"), ("p_unc", "p_unc"), ("ddof2", "DF2"), ("ng2", "ng2")):
        assert found[name].to_numpy(dtype=float) == pytest.approx(peer[theirs].to_numpy(dtype=float), rel=1e-8)
    if k > 2:
        for name in ("p_GG_corr", "eps"):
            theirs = peer[name].to_numpy(dtype=float)[1:]
            assert found[name].to_numpy(dtype=float)[1:] == pytest.approx(theirs, rel=1e-7)


def test_groups_of_unequal_size_weigh_alike() -> None:
    """The mean of group means equals the intercept of sum-coded regression."""
    import statsmodels.api as sm

    table = study((4, 9, 6), 2, np.random.default_rng())
    wide = table.pivot(index="subject", columns="freq", values="y")
    group = table.drop_duplicates("subject").set_index("subject")["hand"]
    codes = np.array([{"left": (1, 0), "right": (0, 1), "both": (-1, -1)}[name] for name in group])
    fit = sm.OLS((wide[1] - wide[0]).to_numpy(), sm.add_constant(codes)).fit()
    found = analysed(table)
    peer = [float(fit.tvalues[0]) ** 2, float(fit.fvalue)]
    of_groups = found.loc[["freq", "hand * freq"], "F"].to_numpy(dtype=float)
    hard_case("groups of 4, 9 and 6", of_groups, peer, 1e-9, against="a regression")


def test_two_within_factors_have_all_group_interactions() -> None:
    table = study((5, 6), 6, np.random.default_rng())
    crossed = table.assign(force=table["freq"] // 3, freq=table["freq"] % 3)
    found = analysed(crossed, ["force", "freq"])
    names = ["hand", "force", "hand * force", "freq", "hand * freq", "force * freq", "hand * force * freq"]
    assert list(found.index) == names
    alike = repeated_measures(crossed, dependent="y", within=["force", "freq"], subject="subject").set_index("Source")
    total = found.loc["force * freq", "ddof2"] + found.loc["hand * force * freq", "ddof1"]
    assert total == alike.loc["force * freq", "ddof2"]


@pytest.mark.parametrize(
    ("sizes", "status", "message"),
    [
        ((4,), DesignStatus.ONE_LEVEL, "hand: found 1 group, expected at least 2 to compare"),
        ((4, 1), DesignStatus.SMALL_GROUP, "hand = right: found one participant, expected at least 2 in each group"),
    ],
)
def test_refuses_groups_that_cannot_be_compared(sizes, status, message) -> None:
    with pytest.raises(UndefinedStatistic, match=f"^{message}$") as refusal:
        analysed(study(sizes, 3, np.random.default_rng()))
    assert refusal.value.status is status


def test_refuses_a_participant_in_two_groups() -> None:
    table = study((3, 3), 3, np.random.default_rng())
    table.loc[1, "hand"] = "right"
    with pytest.raises(InvalidParameter, match="found 2 groups of the participant 0, expected one group; declare it"):
        analysed(table)


def test_a_missing_cell_is_refused_by_name() -> None:
    with pytest.raises(UndefinedStatistic, match=r"subject = 1, freq = 1 \(1 missing cell: 1\)"):
        analysed(study((3, 3), 3, np.random.default_rng()).drop(index=4))


def test_group_pairs_equal_scipy_welch_tests() -> None:
    from scipy.stats import ttest_ind
    from statsmodels.stats.multitest import multipletests

    table = study((5, 7, 4), 3, np.random.default_rng())
    found = group_pairs(table, dependent="y", between="hand", subject="subject")
    means = table.groupby(["hand", "subject"])["y"].mean()
    assert found[["a", "b"]].values.tolist() == [["both", "left"], ["both", "right"], ["left", "right"]]
    peers = [ttest_ind(means[b], means[a], equal_var=False) for a, b in zip(found["a"], found["b"], strict=True)]
    np.testing.assert_allclose(found["t"], [peer.statistic for peer in peers], rtol=1e-12)
    np.testing.assert_allclose(found["difference_low"], [peer.confidence_interval().low for peer in peers], rtol=1e-12)
    holm = multipletests([peer.pvalue for peer in peers], method="holm")[1]
    np.testing.assert_allclose(found["p_corr"], holm, rtol=1e-12)
    assert found[["n_a", "n_b"]].values.tolist() == [[4, 5], [4, 7], [5, 7]]


def test_pairs_of_groups_by_condition_and_as_pingouin() -> None:
    import pingouin

    table = study((5, 7), 3, np.random.default_rng())
    found = group_pairs(table, dependent="y", between="hand", subject="subject", by="freq")
    assert found["freq"].tolist() == [0, 1, 2]
    own = table[table["freq"] == 1]
    left, right = (own.loc[own["hand"] == hand, "y"] for hand in ("left", "right"))
    assert found["g"][1] == pytest.approx(pingouin.compute_effsize(right, left, eftype="hedges"), rel=1e-12)
    alike = pingouin.ttest(right, left, correction=False)["BF10"].iloc[0]
    assert found["bf10"][1] == pytest.approx(float(alike), rel=1e-3)


def test_groups_without_error_or_members_have_no_test() -> None:
    table = pd.DataFrame({"subject": range(4), "hand": ["l", "l", "r", "r"], "y": [1.0, 1, 2, 2]})
    found = group_pairs(table, dependent="y", between="hand", subject="subject")
    assert (found["status"][0], found["difference"][0]) == ("zero_error", 1.0)
    exact_case("groups without error", against="a status, no test")
    with pytest.raises(UndefinedStatistic, match="hand = r: found one participant, expected at least 2 in each group"):
        group_pairs(table[:3], dependent="y", between="hand", subject="subject")
    with pytest.raises(UndefinedStatistic, match="hand: found 1 group"):
        group_pairs(table[:2], dependent="y", between="hand", subject="subject")


def test_between_factor_has_mixed_anova_in_outcome() -> None:
    table = study((5, 6), 3, np.random.default_rng()).rename(columns={"subject": "participant", "y": "threshold"})
    found = outcome(table.assign(status="ok"), ["hand", "freq"], "yes_no", "threshold")
    assert found.anova["Source"].tolist() == ["hand", "freq", "hand * freq"]
    assert list(found.group_pairs) == ["hand"]
    assert set(found.tables("threshold")) >= {"groups_threshold_hand", "pairs_threshold_freq"}
    assert "Welch's t(" in outcome_sentences(found, "dB")["Groups of hand"][0]
    hole = table.drop(index=0).assign(status="ok")
    holed = outcome(hole, ["hand", "freq"], "yes_no", "threshold")
    assert (holed.left_out, holed.primary) == (("participant 0",), "censored_anova")
    assert holed.group_pairs["hand"][["n_a", "n_b"]].values.tolist() == [[5, 6]]


@pytest.mark.parametrize("scale", [1e-300, 1e300])
def test_hard_scales_have_the_same_groups(scale) -> None:
    table = study((5, 6), 3, np.random.default_rng())
    moved = table.assign(y=table["y"] * scale)
    one, other = analysed(table), analysed(moved)
    hard_case("groups of values of 1e-300 and 1e300: F", other["F"], one["F"], 1e-9, against="values of 1")
    given = {"dependent": "y", "between": "hand", "subject": "subject"}
    pairs = [group_pairs(each, **given) for each in (moved, table)]
    for name in ("t", "p_corr", "g", "bf10"):
        assert pairs[0][name].to_numpy() == pytest.approx(pairs[1][name].to_numpy(), rel=1e-9)
    assert pairs[0]["difference_low"].to_numpy() == pytest.approx(pairs[1]["difference_low"] * scale, rel=1e-9)
