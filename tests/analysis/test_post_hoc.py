"""Tests of paired comparisons, equivalence and rank tests, and of the sentences of results."""

import re

import numpy as np
import pandas as pd
import pingouin
import pytest
from designs import drawn, long_table as any_table
from hard_cases import hard_case
from published_design import PUBLISHED, long_table
from scipy import stats
from soak import SOAK

from tactometry.analysis.anova.post_hoc import adjusted_p, bayes_factor, dz_interval, equivalence, evidence, pairs
from tactometry.analysis.anova.within_subjects import checks, permutation_test, repeated_measures
from tactometry.analysis.mixed_models.linear import mixed_model
from tactometry.analysis.report.texts import table_sentences
from tactometry.analysis.wording import p_text, share_text
from tactometry.errors import InvalidParameter


@pytest.fixture(scope="module")
def published() -> pd.DataFrame:
    return long_table(np.array(PUBLISHED.split(), dtype=float).reshape(8, 12))


@pytest.fixture(scope="module")
def found(published) -> pd.DataFrame:
    return pairs(published, dependent="y", factor="freq", subject="subject").set_index(["a", "b"])


def test_published_pairs_and_holm_correction(found) -> None:
    assert found.index.tolist() == [(60, 120), (60, 240), (60, 480), (120, 240), (120, 480), (240, 480)]
    assert -found["t"].to_numpy() == pytest.approx([28.5269, 33.4838, 46.8781, 17.4125, 5.7537, -8.4913], abs=5e-5)
    assert found.loc[(120, 480), "p_corr"] == pytest.approx(6.958e-4, rel=1e-3)
    assert found.loc[(240, 480), "p_corr"] == pytest.approx(1.244e-4, rel=1e-3)


@pytest.mark.parametrize("correction", ["holm", "bonferroni", "sidak", "fdr_bh"])
def test_corrections_equal_pingouin_and_skip_missing_p(correction) -> None:
    p = np.insert(np.random.default_rng().random(9) ** 3, [0, 4], np.nan)
    peer = pingouin.multicomp(p, method=correction.replace("bonferroni", "bonf"))[1]
    assert adjusted_p(pd.Series(p), correction).tolist() == pytest.approx(peer.tolist(), nan_ok=True, rel=1e-15)


def test_pairs_equal_scipy_and_pingouin() -> None:
    values = drawn((12, 2), np.random.default_rng())
    row = pairs(any_table(values), dependent="y", factor="force", subject="subject").iloc[0]
    peer = stats.ttest_rel(values[:, 1], values[:, 0])
    assert row["t"] == pytest.approx(peer.statistic)
    assert row["p_unc"] == pytest.approx(peer.pvalue)
    assert (row["difference_low"], row["difference_high"]) == pytest.approx(tuple(peer.confidence_interval(0.95)))
    assert row["bf10"] == pytest.approx(float(pingouin.bayesfactor_ttest(peer.statistic, 12, paired=True)))
    assert row["dz"] == pytest.approx(row["t"] / np.sqrt(12))


def test_simple_pairs_are_corrected_together(published) -> None:
    table = pairs(published, dependent="y", factor="force", by="freq", subject="subject")
    assert len(table) == 3 * 4
    low = table.loc[table["p_unc"].idxmin()]
    assert low["p_corr"] == pytest.approx(12 * low["p_unc"])
    one = published[published["freq"] == 240]
    alone = pairs(one, dependent="y", factor="force", subject="subject")
    assert table[table["freq"] == 240]["t"].to_numpy() == pytest.approx(alone["t"].to_numpy())


@pytest.mark.parametrize(("t", "n"), [(0.0, 5), (2.5, 10), (-46.9, 8), (300.0, 4), (1e-9, 200)])
def test_dz_interval_excludes_half_alpha_per_side(t, n) -> None:
    low, high = dz_interval(t, n, 0.95)
    assert low < t / np.sqrt(n) < high
    assert stats.nct.sf(t, n - 1, low * np.sqrt(n)) == pytest.approx(0.025, abs=1e-6)
    assert stats.nct.cdf(t, n - 1, high * np.sqrt(n)) == pytest.approx(0.025, abs=1e-6)


def test_identical_differences_have_no_test() -> None:
    values = np.arange(5.0)[:, None] + np.array([0.0, 2.0, 2.0])
    table = pairs(any_table(values), dependent="y", factor="force", subject="subject")
    assert table["status"].tolist() == ["zero_error"] * 3
    assert table["difference"].tolist() == [2.0, 2.0, 0.0]
    assert table[["t", "p_unc", "p_corr", "bf10"]].isna().to_numpy().all()


@pytest.mark.parametrize("scale", [1e-300, 1e300])
def test_hard_scales_have_the_same_pairs(published, found, scale) -> None:
    table = published.assign(y=published["y"] * scale)
    given = {"dependent": "y", "factor": "freq", "subject": "subject"}
    other = pairs(table, **given).set_index(["a", "b"])
    hard_case("pairs of values of 1e-299 to 1e301: t", other["t"], found["t"], 1e-9, against="values of 1")
    for name in ("p_corr", "dz_low", "bf10"):
        assert other[name].to_numpy() == pytest.approx(found[name].to_numpy(), rel=1e-9)
    for name in ("difference", "difference_low", "difference_high"):
        assert other[name].to_numpy() == pytest.approx(found[name].to_numpy() * scale, rel=1e-9)
    tests = [equivalence(each, bound=1.5 * unit, **given) for each, unit in ((table, scale), (published, 1.0))]
    assert tests[0]["p"].to_numpy() == pytest.approx(tests[1]["p"].to_numpy(), rel=1e-9)
    assert tests[0]["high"].to_numpy() == pytest.approx(tests[1]["high"].to_numpy() * scale, rel=1e-9)


@pytest.mark.parametrize(
    ("t", "sizes", "bf10"),
    [
        (0.0, (2,), 0.523198073620),
        (1e20, (2,), 37.0951283346),
        (562.0, (3,), 387.777239921),
        (-3160.0, (3,), 2182.69374081),
        (1e6, (4,), 188034794836.0),
        (1e4, (8,), 7.75281127859e20),
        (57.4, (1000,), np.inf),
        (315.0, (2, 2), 126.145471834),
        (200.0, (2, 30), 5.52262382051e43),
    ],
)
def test_bayes_factors_of_large_t_match_high_precision(t, sizes, bf10) -> None:
    assert bayes_factor(t, *sizes) == pytest.approx(bf10, rel=1e-9)


@pytest.mark.parametrize("t", [0.0, -0.3, 2.5, 30.0, 100.0])
def test_bayes_factors_equal_pingouin_at_moderate_t(t) -> None:
    for sizes in ((3,), (24,), (2, 2), (5, 12)):
        peer = pingouin.bayesfactor_ttest(t, *sizes, paired=len(sizes) == 1)
        assert bayes_factor(t, *sizes) == pytest.approx(float(peer), rel=1e-6)


@pytest.mark.parametrize("n", [3, 6, 40])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_dz_interval_is_continuous_for_vast_effects(n, sign) -> None:
    """Regression test: from t = 1e6 on intervals were the effect itself."""
    at = 1e4 * np.sqrt(n - 1)
    near, far = (np.array(dz_interval(sign * t, n, 0.95)) / t for t in (0.999 * at, 1.001 * at))
    assert far == pytest.approx(near, rel=1e-5)
    assert np.array(dz_interval(sign * 1e12, n, 0.95)) / 1e12 == pytest.approx(far, rel=1e-6)


@pytest.mark.parametrize("spread", [2e-2, 2e-3, 2e-6])
def test_nearly_identical_differences_have_bayes_factor(spread) -> None:
    values = np.array([[0.0, 20.0], [1.0, 21.0 + spread], [2.0, 22.0 - spread]])
    found = pairs(any_table(values), dependent="y", factor="force", subject="subject").iloc[0]
    # Far out the null has no chance: the factor grows as t^(n - 2), here as t.
    assert found["bf10"] / found["t"] == pytest.approx(0.690884, rel=1e-3)


@pytest.mark.parametrize("bf10", [0.001, 0.4, 1.0, 2.9, 3.1, 99.0, 1e9])
def test_evidence_has_a_label(bf10) -> None:
    assert evidence(bf10).endswith("no difference" if bf10 < 1 else "a difference")


def test_equivalence_equals_pingouin() -> None:
    values = drawn((14, 2), np.random.default_rng())
    row = equivalence(any_table(values), dependent="y", factor="force", subject="subject", bound=1.5).iloc[0]
    peer = pingouin.tost(values[:, 1], values[:, 0], bound=1.5, paired=True)
    assert row["p"] == pytest.approx(float(peer["pval"].iloc[0]), rel=1e-9)


def test_equivalence_holds_when_interval_is_within_bound(published) -> None:
    for bound in (0.3, 0.6, 0.9, 1.2, 1.5):
        table = equivalence(published, dependent="y", factor="force", by="freq", subject="subject", bound=bound)
        inside = (table["low"] > -bound) & (table["high"] < bound)
        assert table["equivalent"].tolist() == inside.tolist()
        assert table.attrs["p_all"] == table["p"].max()


@pytest.mark.slow
def test_equivalence_error_rate_at_bound_is_alpha() -> None:
    rng = np.random.default_rng()
    n_studies = 4000 if SOAK else 400
    claims = 0
    for values in rng.normal(size=(n_studies, 12, 2)) + np.array([0.0, 1.0]) * 1.0:
        table = equivalence(any_table(values), dependent="y", factor="force", subject="subject", bound=1.0)
        claims += bool(table["equivalent"].iloc[0])
    assert claims / n_studies <= 0.05 + 3.9 * np.sqrt(0.05 * 0.95 / n_studies)


def test_identical_differences_are_compared_with_bound() -> None:
    values = np.arange(5.0)[:, None] + np.array([0.0, 2.0])
    given = {"dependent": "y", "factor": "force", "subject": "subject"}
    claims = [equivalence(any_table(values), **given, bound=bound)["equivalent"][0] for bound in (1.0, 3.0)]
    assert claims == [False, True]


BAD = (0.0, -1.0, np.nan, np.inf)


@pytest.mark.parametrize(
    ("compare", "options", "message"),
    [
        (pairs, {"correction": "holms"}, "correction: found 'holms', expected one of holm, bonferroni"),
        (equivalence, {"bound": 1.0, "alpha": 0.5}, "alpha: found 0.5, expected a number above 0 and below 0.5"),
        *((equivalence, {"bound": x}, f"bound: found {x}, expected a difference above 0, in the unit") for x in BAD),
    ],
)
def test_invalid_options_of_comparisons_are_refused(published, compare, options, message) -> None:
    with pytest.raises(InvalidParameter, match=re.escape(message)):
        compare(published, dependent="y", factor="force", subject="subject", **options)


ARGUMENTS = {"dependent": "y", "subject": "subject"}


@pytest.fixture(scope="module")
def table():
    return any_table(drawn((9, 3, 2), np.random.default_rng()))


@pytest.mark.parametrize(
    ("p", "text"),
    [(0.0004, "p < .001"), (0.001, "p = .001"), (0.05, "p = .050"), (0.99949, "p = .999"), (1.0, "p > .999")],
)
def test_p_text_has_three_digits_without_leading_zero(p, text) -> None:
    assert p_text(p) == text


@pytest.mark.parametrize(("x", "text"), [(0.5, ".500"), (-0.25, "-.250"), (1.0, "1.000"), (10.5, "10.500")])
def test_proportion_is_printed_without_leading_zero(x, text) -> None:
    assert share_text(x) == text


def test_effect_sentence_contains_its_numbers(table) -> None:
    found = repeated_measures(table, within=["force", "freq"], **ARGUMENTS)
    first, second, _ = table_sentences("anova", found)
    row = found.iloc[0]
    if row["eps_CM"] < 1:
        assert first.startswith(f"force: F({2 * row['eps_CM']:.2f}, {16 * row['eps_CM']:.2f}) = {row['F']:.2f}, ")
        assert f"(Chi-Muller, epsilon = {row['eps_CM']:.2f})" in first
    assert p_text(row["p_CM_corr"]) in first
    assert second.startswith("freq: F(1, 8) = ")
    assert "Muller" not in second


def test_every_result_has_its_sentence(table) -> None:
    within = ["force", "freq"]
    tested = equivalence(table, factor="force", bound=50.0, **ARGUMENTS)
    model = mixed_model(table, factors=within, **ARGUMENTS)
    sentences = [
        *table_sentences("permutation", permutation_test(table, within=within, **ARGUMENTS)),
        *table_sentences("pairs", pairs(table, factor="force", **ARGUMENTS), "dB"),
        *table_sentences("equivalence", tested, tested.attrs, "dB"),
        *table_sentences("model", model.terms, model),
    ]
    assert all("nan" not in sentence and "None" not in sentence for sentence in sentences)
    assert sum("p " in sentence for sentence in sentences) >= len(sentences) - 2
    assert any("pairs are equivalent within +-50 dB" in sentence for sentence in sentences)


F_TEST = {"Source": "a * b", "ddof1": 2, "ddof2": 14, "F": 8.1, "eps_CM": 1.0, "np2": 0.536}
WELCH = {"a": "left", "b": "right", "difference": 3.0, "simultaneous_low": 0.73, "simultaneous_high": 5.27, "df": 4.0}
WELCH |= {"t": 3.674, "p_unc": 0.021, "p_corr": 0.021, "g": 2.4, "bf10": 3.6, "status": "ok"}
TOST = {"a": 0.5, "b": 1.0, "difference": 0.02, "low": -0.3, "high": 0.35, "p": 0.001, "equivalent": True}
NO_ALPHA = {"frequency_hz": 60.0, "dimension": "PQ", "alpha": None, "note": "fewer than three participants"}


@pytest.mark.parametrize(
    ("kind", "row", "facts", "text"),
    [
        ("simple", F_TEST | {"hz": 60, "p_corr": 0.009, "note": ""}, ["hz"],
         "hz 60: a * b, F(2, 14) = 8.10, p = .009 (Holm), partial eta squared = .536"),
        ("permutation", F_TEST | {"p_permutation": 0.25, "n_permutations": 512}, [],
         "a * b: permutation test with 512 sign changes, F = 8.10, p = .250"),
        ("pairs", WELCH, ["dB"],
         "right − left: 3.00 dB, 95 % CI [0.73, 5.27], Welch's t(4) = 3.67, p = .021, g = 2.40, BF10 = 3.6, "
         "moderate evidence for a difference"),
        ("equivalence", TOST, [{"p_all": 0.001, "bound": 1.0, "alpha": 0.05}, "dB", "force_n"],
         "1 N and 0.5 N are equivalent within +-1 dB: difference 0.020 dB, 90 % CI [-0.300, 0.350], TOST p = .001"),
        ("alpha", NO_ALPHA, [["frequency_hz"]],
         "60 Hz, PQ: no Cronbach's alpha (fewer than three participants)"),
    ],
)  # fmt: skip
def test_sentence_of_one_row(kind, row, facts, text) -> None:
    assert table_sentences(kind, pd.DataFrame([row]), *facts) == [text]


def test_equivalence_sentences_deny_unmet_claims() -> None:
    values = np.random.default_rng().normal(size=(8, 2)) + np.array([0, 5.0])
    tested = equivalence(any_table(values), factor="force", bound=0.5, **ARGUMENTS)
    assert all("not" in sentence for sentence in table_sentences("equivalence", tested, tested.attrs))


def test_pair_sentence_reports_differences_without_error() -> None:
    values = np.arange(4.0)[:, None] + np.array([0.0, 2.0])
    (sentence,) = table_sentences("pairs", pairs(any_table(values), factor="force", **ARGUMENTS))
    assert sentence == "1 − 0: 2.00 in every participant: not tested, as the error is 0"


def checked(table, within):
    return checks(table, repeated_measures(table, within=within, **ARGUMENTS), within=within, **ARGUMENTS)


def test_normality_check_uses_residuals() -> None:
    values = drawn((8, 3), np.random.default_rng())
    row = checked(any_table(values), "force").iloc[0]
    left = values - values.mean(0) - values.mean(1, keepdims=True) + values.mean()
    peer = stats.shapiro(left.ravel())
    assert (row["statistic"], row["p"]) == pytest.approx((peer.statistic, peer.pvalue), rel=1e-6)


def test_outlier_is_counted_and_contradicts_normality() -> None:
    values = np.random.default_rng().normal(size=(30, 3))
    values[4, 1] += 40
    found = checked(any_table(values), "force")
    assert found["holds"].tolist()[0] is False
    assert found["statistic"].iloc[-1] >= 1
    assert "contradicted" in found["text"][0]


def test_checks_report_reason_when_test_is_impossible() -> None:
    found = checked(any_table(drawn((5, 6, 2), np.random.default_rng())), ["force", "freq"])
    texts = found["text"].tolist()
    assert texts[1] == "sphericity of force: not tested, the error matrix is singular"
    assert texts[2] == "sphericity of freq: not tested, two levels are always spherical"
    assert found["holds"].tolist()[1] is None
