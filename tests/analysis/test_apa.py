"""Tests of the sentences of results and of printed assumption checks."""

import numpy as np
import pandas as pd
import pytest
from designs import drawn, long_table
from scipy import stats

from tactometry.analysis.anova.post_hoc import equivalence, pairs
from tactometry.analysis.anova.within_subjects import checks, permutation_test, repeated_measures
from tactometry.analysis.mixed_models.linear import mixed_model
from tactometry.analysis.report.sentences import table_sentences
from tactometry.analysis.wording import p_text, share_text

ARGUMENTS = {"dependent": "y", "subject": "subject"}


@pytest.fixture(scope="module")
def table():
    return long_table(drawn((9, 3, 2), np.random.default_rng()))


@pytest.mark.parametrize(
    ("p", "text"),
    [(0.0004, "p < .001"), (0.001, "p = .001"), (0.05, "p = .050"), (0.99949, "p = .999"), (1.0, "p > .999")],
)
def test_p_text_has_three_digits_without_leading_zero(p, text) -> None:
    assert p_text(p) == text


@pytest.mark.parametrize(("x", "text"), [(0.5, ".500"), (-0.25, "-.250"), (1.0, "1.000"), (10.5, "10.500")])
def test_a_share_has_no_leading_zero(x, text) -> None:
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
    tested = equivalence(long_table(values), factor="force", bound=0.5, **ARGUMENTS)
    told = table_sentences("equivalence", tested, tested.attrs)
    assert all("not" in sentence for sentence in told)


def test_pair_sentence_reports_differences_without_error() -> None:
    values = np.arange(4.0)[:, None] + np.array([0.0, 2.0])
    (told,) = table_sentences("pairs", pairs(long_table(values), factor="force", **ARGUMENTS))
    assert told == "1 − 0: 2.00 in every participant: not tested, as the error is 0"


def checked(table, within):
    return checks(table, repeated_measures(table, within=within, **ARGUMENTS), within=within, **ARGUMENTS)


def test_normality_check_uses_residuals() -> None:
    values = drawn((8, 3), np.random.default_rng())
    row = checked(long_table(values), "force").iloc[0]
    left = values - values.mean(0) - values.mean(1, keepdims=True) + values.mean()
    peer = stats.shapiro(left.ravel())
    assert (row["statistic"], row["p"]) == pytest.approx((peer.statistic, peer.pvalue), rel=1e-6)


def test_outlier_is_counted_and_contradicts_normality() -> None:
    values = np.random.default_rng().normal(size=(30, 3))
    values[4, 1] += 40
    found = checked(long_table(values), "force")
    assert found["holds"].tolist()[0] is False
    assert found["statistic"].iloc[-1] >= 1
    assert "contradicted" in found["text"][0]


def test_checks_report_reason_when_test_is_impossible() -> None:
    found = checked(long_table(drawn((5, 6, 2), np.random.default_rng())), ["force", "freq"])
    texts = found["text"].tolist()
    assert texts[1] == "sphericity of force: not tested, the error matrix is singular"
    assert texts[2] == "sphericity of freq: not tested, two levels are always spherical"
    assert found["holds"].tolist()[1] is None
