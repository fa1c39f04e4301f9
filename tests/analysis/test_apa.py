"""Tests of the sentences of results and of printed assumption checks."""

import numpy as np
import pytest
from designs import drawn, long_table
from scipy import stats

from tactometry.analysis.anova.post_hoc import equivalence, pairs
from tactometry.analysis.anova.within_subjects import checks, permutation_test, repeated_measures
from tactometry.analysis.mixed_models.linear import mixed_model
from tactometry.analysis.report.sentences import (
    anova_sentences,
    equivalence_sentences,
    model_sentences,
    pair_sentences,
    permutation_sentences,
)
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
    first, second, _ = anova_sentences(found)
    row = found.iloc[0]
    if row["eps_CM"] < 1:
        assert first.startswith(f"force: F({2 * row['eps_CM']:.2f}, {16 * row['eps_CM']:.2f}) = {row['F']:.2f}, ")
        assert f"(Chi-Muller, epsilon = {row['eps_CM']:.2f})" in first
    assert p_text(row["p_CM_corr"]) in first
    assert second.startswith("freq: F(1, 8) = ")
    assert "Muller" not in second


def test_every_result_has_its_sentence(table) -> None:
    within = ["force", "freq"]
    told = [
        *permutation_sentences(permutation_test(table, within=within, **ARGUMENTS)),
        *pair_sentences(pairs(table, factor="force", **ARGUMENTS), "dB"),
        *equivalence_sentences(equivalence(table, factor="force", bound=50.0, **ARGUMENTS), "dB"),
        *model_sentences(mixed_model(table, factors=within, **ARGUMENTS)),
    ]
    assert all("nan" not in sentence and "None" not in sentence for sentence in told)
    assert sum("p " in sentence for sentence in told) >= len(told) - 2
    assert any("pairs are equivalent within +-50 dB" in sentence for sentence in told)


def test_equivalence_sentences_deny_unmet_claims() -> None:
    values = np.random.default_rng().normal(size=(8, 2)) + np.array([0, 5.0])
    told = equivalence_sentences(equivalence(long_table(values), factor="force", bound=0.5, **ARGUMENTS))
    assert all("not" in sentence for sentence in told)


def test_pair_sentence_reports_differences_without_error() -> None:
    values = np.arange(4.0)[:, None] + np.array([0.0, 2.0])
    (told,) = pair_sentences(pairs(long_table(values), factor="force", **ARGUMENTS))
    assert told == "1 − 0: 2.00 in every participant: no test, as there is no error"


# --- assumptions


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
