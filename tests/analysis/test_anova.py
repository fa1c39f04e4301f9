"""Tests of ANOVA within and between participants: published values, peers and invariances."""

import math
import re
import warnings

import numpy as np
import pandas as pd
import pytest
from designs import study
from hard_cases import exact_case, hard_case
from published_design import PUBLISHED, WITHIN, long_table

from tactometry.analysis.anova.bounded_design import largest_complete
from tactometry.analysis.anova.design import DesignStatus, UndefinedStatistic
from tactometry.analysis.anova.split_plot import group_pairs, mixed_anova
from tactometry.analysis.anova.within_subjects import repeated_measures
from tactometry.analysis.outcomes.outcome import outcome
from tactometry.analysis.report.texts import outcome_sentences
from tactometry.errors import InvalidParameter


@pytest.fixture
def published() -> pd.DataFrame:
    return long_table(np.array(PUBLISHED.split(), dtype=float).reshape(8, 12))


def analysed(table: pd.DataFrame, within=WITHIN) -> pd.DataFrame:
    return repeated_measures(table, dependent="y", within=within, subject="subject").set_index("Source")


@pytest.mark.parametrize(
    ("effect", "ss", "f", "p", "w", "epsilon", "p_corrected", "ng2"),
    [
        ("force", 29.930990, 38.121061, 2.162874e-6, 0.888157, 0.899408, 6.290984e-6, 0.105953),
        ("freq", 778.992500, 625.427670, 1.093439e-20, 0.489410, 0.665974, 2.097376e-14, 0.755163),
        ("force * freq", 5.342344, 1.980857, 0.09005187, 0.080312, 0.611773, 0.1319352, 0.020714),
    ],
)
def test_published_two_way_analysis(published, effect, ss, f, p, w, epsilon, p_corrected, ng2) -> None:
    row = analysed(published).loc[effect]
    assert row["SS"] == pytest.approx(ss, rel=1e-7)
    assert row["F"] == pytest.approx(f, rel=1e-6)
    assert row["p_unc"] == pytest.approx(p, rel=1e-6)
    assert row["W_spher"] == pytest.approx(w, abs=1e-6)
    assert row["eps"] == pytest.approx(epsilon, abs=1e-6)
    assert row["p_GG_corr"] == pytest.approx(p_corrected, rel=1e-5)
    assert row["ng2"] == pytest.approx(ng2, abs=1e-6)


@pytest.mark.parametrize(("scale", "offset"), [(1.0, 1e9), (1e-12, 0.0), (1e12, -3.0), (1e-300, 0.0), (1e300, 0.0)])
@pytest.mark.parametrize("within", [WITHIN, ["freq"]])
def test_anova_ignores_scale_and_offset(published, within, scale: float, offset: float) -> None:
    moved = published.assign(y=published["y"] * scale + offset)
    one, other = (analysed(table, within).drop(index="Error", errors="ignore") for table in (published, moved))
    hard_case("ANOVA of values of 1e-299 to 1e301, and 1e9 away: F", other["F"], one["F"], 1e-4, against="values of 1")
    for name in ("F", "p_unc", "p_CM_corr", "np2_low", "ng2", "W_spher"):
        expected = pytest.approx(one[name].to_numpy(), rel=1e-3 if offset else 1e-9, nan_ok=True)
        assert other[name].to_numpy() == expected
    with np.errstate(over="ignore"):
        ss = one["SS"].to_numpy() * scale * scale
    assert other["SS"].to_numpy() == pytest.approx(ss, rel=1e-4 if offset else 1e-9)


def test_two_levels_have_the_columns_of_more(published) -> None:
    two = repeated_measures(published[published["freq"] < 200], dependent="y", within="freq", subject="subject")
    more = repeated_measures(published, dependent="y", within="freq", subject="subject")
    assert list(two.columns) == list(more.columns)
    assert two.loc[0, ["p_GG_corr", "p_HF_corr", "p_CM_corr"]].tolist() == [two.loc[0, "p_unc"]] * 3
    crossed = analysed(published).reset_index()
    assert set(crossed.columns) == set(more.columns) - {"DF"}


def test_effect_has_no_f_when_error_is_zero() -> None:
    rng = np.random.default_rng()
    values = np.arange(6.0)[:, None, None] + np.array([0.0, 3.0])[None, :, None] + rng.normal(size=(6, 1, 3))
    table = long_table(values, forces=(1, 2), frequencies=(60, 120, 240))
    found = repeated_measures(table, dependent="y", within=WITHIN, subject="subject")
    assert found["F"].notna().tolist() == [False, True, False]
    assert found.attrs["notes"] == [
        f"{name}: found the same differences in all participants, so the error is 0 and F is undefined"
        for name in ("force", "force * freq")
    ]
    assert found["np2"].isna().tolist() == [True, False, True]
    exact_case("one effect without error beside one with: ANOVA", against="a note")


def test_anova_ignores_row_order_and_participant_names(published) -> None:
    shuffled = published.sample(frac=1.0, random_state=np.random.default_rng().integers(2**31))
    renamed = shuffled.assign(subject=shuffled["subject"].map(lambda code: f"{code[::-1]} x"))
    assert analysed(renamed)["F"].to_numpy() == pytest.approx(analysed(published)["F"].to_numpy(), rel=1e-9)


def test_names_with_spaces_and_unused_categories_are_harmless(published) -> None:
    table = published.rename(columns={"freq": "the frequency"})
    table["force"] = pd.Categorical(table["force"], categories=[0.5, 1, 2, 9])
    found = repeated_measures(table, dependent="y", within=["force", "the frequency"], subject="subject")
    assert found["F"].to_numpy() == pytest.approx(analysed(published)["F"].to_numpy(), rel=1e-9)


def test_several_values_per_cell_are_averaged_with_note(published) -> None:
    twice = pd.concat([published.assign(y=published["y"] + d) for d in (-1, 1)])
    found = repeated_measures(twice, dependent="y", within=WITHIN, subject="subject")
    assert found.attrs["notes"] == ["several values of one participant in one cell were averaged"]
    assert found["F"].to_numpy() == pytest.approx(analysed(published)["F"].to_numpy(), rel=1e-9)


def with_value(table: pd.DataFrame, row: int, value: object) -> pd.DataFrame:
    changed = table.astype({"y": object})
    changed.loc[row, "y"] = value
    return changed


SUBJECTS = np.arange(8.0)[:, None]
CONDITIONS = np.arange(12.0)


NOT_FINITE = "(subject = P1, force = {}, freq = {}), expected a finite number; remove the participant or the condition"
ALL_ALIKE = "y: found the same differences in all participants, expected some error, without which F is undefined"
HOLE = (
    "y: found no value for subject = {}, expected one in every cell; remove the participant or the condition, or fit "
)
HOLE += "a mixed model"
NONE_WITHIN = "y: found no difference between the conditions of any participant, expected differences, without which F "
NONE_WITHIN += "is undefined"
FEW = "expected at least 3 to compare"
UNSORTED = "freq: found values that cannot be sorted (list), expected numbers or text"
NO_NAME = "found nothing, expected the name of a participant or a condition; remove the row"


@pytest.mark.parametrize(
    ("make", "message", "status"),
    [
        (lambda t: t.assign(y=3.25), "y: found the same value everywhere, expected values that differ", "constant"),
        (lambda t: t.assign(y=-3e9), "y: found the same value everywhere, expected values that differ", "constant"),
        (lambda t: t.assign(y=np.repeat(np.arange(8.0), 12)), NONE_WITHIN, "no_variance_within"),
        (lambda t: t.assign(y=(SUBJECTS + CONDITIONS**2).ravel()), ALL_ALIKE, "zero_error"),
        (lambda t: t.assign(y=(0 * SUBJECTS + CONDITIONS**2).ravel()), ALL_ALIKE, "zero_error"),
        (lambda t: t.drop(index=17), HOLE.format("P2, force = 1.0, freq = 120 (1 missing cell: P2)"), "missing_cell"),
        (
            lambda t: t.query("not (subject == 'P3' and freq == 480)"),
            HOLE.format("P3, force = 0.5, freq = 480 (3 missing cells: P3)"),
            "missing_cell",
        ),
        (lambda t: t[t["subject"] == "P1"], f"subject: found 1 participant, {FEW}", "too_few_participants"),
        (lambda t: t[t["subject"] < "P3"], f"subject: found 2 participants, {FEW}", "too_few_participants"),
        (lambda t: t[t["freq"] == 60], "freq: found 1 value, expected at least 2 to compare", "one_level"),
        (lambda t: t.iloc[:0], "table: found no row, expected values to compare", "no_data"),
        (lambda t: with_value(t, 5, math.nan), f"y, row 5: found nan {NOT_FINITE.format(1.0, 120)}", "not_finite"),
        (lambda t: with_value(t, 5, -math.inf), f"y, row 5: found -inf {NOT_FINITE.format(1.0, 120)}", "not_finite"),
        (lambda t: with_value(t, 0, "loud"), f"y, row 0: found loud {NOT_FINITE.format(0.5, 60)}", "not_finite"),
        (lambda t: t.assign(subject=t["subject"].where(t.index != 24)), f"subject, row 24: {NO_NAME}", "no_name"),
        (lambda t: t.assign(freq=t["freq"].where(t.index != 7)), f"freq, row 7: {NO_NAME}", "no_name"),
        (lambda t: t.assign(freq=[[x] for x in t["freq"]]), UNSORTED, None),
        (
            lambda t: t.rename(columns={"freq": "frec"}),
            "repeated_measures: found no column 'freq'; did you mean 'frec'?",
            None,
        ),
    ],
)
def test_undefined_analysis_is_refused_with_its_status(published, make, message: str, status) -> None:
    with pytest.raises(InvalidParameter, match=f"^{re.escape(message)}$") as refusal:
        analysed(make(published))
    assert getattr(refusal.value, "status", None) == status
    exact_case("differences without error, one value, holes: ANOVA", against="one sentence")


def test_refuses_four_factors(published) -> None:
    table = published.assign(third=1, fourth=2)
    with pytest.raises(InvalidParameter, match="expected one to three different factors"):
        analysed(table, [*WITHIN, "third", "fourth"])


@pytest.mark.parametrize(
    ("is_kept", "within", "left_out", "n_rows"),
    [
        (lambda t: t["y"] > 0, ("force", "freq"), (), 96),
        (lambda t: t.index != 17, ("force", "freq"), ("participant P2",), 84),
        (lambda t: t["freq"] != 480, ("force", "freq"), ("freq = 480",), 72),
        (lambda t: t["force"] == 1, ("freq",), ("force = 0.5", "force = 2.0"), 32),
    ],
    ids=["complete", "participant", "condition", "factor"],
)
def test_largest_complete_part_omits_missing_cells(published, is_kept, within, left_out, n_rows) -> None:
    table = published.assign(y=published["y"].where(is_kept(published)))
    part = largest_complete(table, dependent="y", within=WITHIN, subject="subject")
    assert (part.within, part.left_out, len(part.table)) == (within, left_out, n_rows)


def complete_part(sides):
    """Return the largest complete part of participants with values at these sides."""
    rows = [(f"P{n}", side, 1.0 if side in known else None) for n, known in enumerate(sides, 1) for side in "abc"]
    table = pd.DataFrame(rows, columns=["participant", "side", "threshold"])
    return largest_complete(table, dependent="threshold", within=["side"], subject="participant")


@pytest.mark.parametrize(("n_complete", "exists"), [(1, False), (2, False), (3, True)])
def test_complete_part_has_at_least_three_participants(n_complete, exists) -> None:
    assert (complete_part(["ab"] * n_complete + ["a"] * (4 - n_complete)) is not None) == exists


@pytest.mark.parametrize(
    ("sides", "left_out"),
    [
        (["abc"] * 4 + ["ab"] * 2, ("side = c",)),
        (["ab"] * 3 + ["bc"] * 3, ("participant P4", "participant P5", "participant P6", "side = c")),
    ],
    ids=["more participants", "earlier levels"],
)
def test_tied_complete_parts_are_resolved(sides, left_out) -> None:
    assert complete_part(sides).left_out == left_out


def mixed(table, within="freq") -> pd.DataFrame:
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
    found = mixed(table)
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
    found = mixed(table)
    peer = [float(fit.tvalues[0]) ** 2, float(fit.fvalue)]
    of_groups = found.loc[["freq", "hand * freq"], "F"].to_numpy(dtype=float)
    hard_case("groups of 4, 9 and 6", of_groups, peer, 1e-9, against="a regression")


def test_two_within_factors_have_all_group_interactions() -> None:
    table = study((5, 6), 6, np.random.default_rng())
    crossed = table.assign(force=table["freq"] // 3, freq=table["freq"] % 3)
    found = mixed(crossed, ["force", "freq"])
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
        mixed(study(sizes, 3, np.random.default_rng()))
    assert refusal.value.status is status


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
    one, other = mixed(table), mixed(moved)
    hard_case("groups of values of 1e-300 and 1e300: F", other["F"], one["F"], 1e-9, against="values of 1")
    given = {"dependent": "y", "between": "hand", "subject": "subject"}
    pairs = [group_pairs(each, **given) for each in (moved, table)]
    for name in ("t", "p_corr", "g", "bf10"):
        assert pairs[0][name].to_numpy() == pytest.approx(pairs[1][name].to_numpy(), rel=1e-9)
    assert pairs[0]["difference_low"].to_numpy() == pytest.approx(pairs[1]["difference_low"] * scale, rel=1e-9)
