"""Tests of ANOVA contrasts: peers, sphericity, permutations, and simulated error rates."""

import warnings
from collections.abc import Mapping
from itertools import product

import numpy as np
import pandas as pd
import pytest
from designs import GIVEN, NAMES, cut, drawn, long_table
from examples import examples
from hypothesis import given, strategies as st
from scipy.special import fdtrc
from scipy.stats import f as fisher, ncf, norm, t as student
from soak import SOAK

from tactometry.analysis.anova.censored import censored_anova
from tactometry.analysis.anova.design import (
    ContrastEffect,
    DesignStatus,
    WithinDesign,
    contrasts,
    effects,
    epsilons,
    permutation_p,
)
from tactometry.analysis.anova.group_means import DIFFERENCE, within_variances
from tactometry.analysis.anova.post_hoc import pairs
from tactometry.analysis.anova.within_subjects import (
    EffectTest,
    effect_table,
    eta_squared,
    noncentrality,
    permutation_test,
    repeated_measures,
    singular_note,
)
from tactometry.errors import InvalidParameter


def design_of(values: np.ndarray) -> WithinDesign:
    levels = tuple(tuple(range(k)) for k in values.shape[1:])
    return WithinDesign(values, NAMES[: values.ndim - 1], levels, tuple(range(len(values))))


def analysed(values: np.ndarray) -> pd.DataFrame:
    return repeated_measures(long_table(values), dependent="y", within=NAMES[: values.ndim - 1], subject="subject")


@pytest.mark.parametrize("shape", [(6, 3), (10, 3, 7), (13, 3, 4), (9, 2, 2), (30, 2, 5)])
def test_contrasts_equal_pingouin(shape) -> None:
    rng = np.random.default_rng()
    for _ in range(20 if SOAK else 1):
        check_against_pingouin(drawn(shape, rng))


def check_against_pingouin(values) -> None:
    import pingouin

    within = list(NAMES[: values.ndim - 1])
    options = {"within": within if len(within) > 1 else within[0], "correction": True, "effsize": "ng2"}
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        peer = pingouin.rm_anova(long_table(values), dv="y", subject="subject", detailed=True, **options)
    found = analysed(values)
    assert set(peer.columns) <= set(found.columns)
    assert found["Source"].tolist() == peer["Source"].tolist()
    is_regular = ~np.array([effect.is_singular for effect in effects(design_of(values))])
    for name in set(peer.columns) - {"Source"}:
        ours, theirs = (table[name].to_numpy(dtype=float)[: len(is_regular)] for table in (found, peer))
        compared = is_regular if name in ("W_spher", "p_spher", "sphericity") else slice(None)
        assert ours[compared] == pytest.approx(theirs[compared], rel=1e-7, abs=1e-300, nan_ok=True)


@pytest.mark.parametrize("shape", [(6, 2, 3, 2), (5, 3, 2, 4)])
def test_three_factors_equal_statsmodels(shape) -> None:
    from statsmodels.stats.anova import AnovaRM

    values = drawn(shape, np.random.default_rng())
    peer = AnovaRM(long_table(values), "y", "subject", within=list(NAMES)).fit().anova_table
    found = analysed(values).set_index("Source")
    assert [name.replace(" * ", ":") for name in found.index] == list(peer.index)
    assert found["F"].to_numpy() == pytest.approx(peer["F Value"].to_numpy(), rel=1e-8)
    assert found["p_unc"].to_numpy() == pytest.approx(peer["Pr > F"].to_numpy(), rel=1e-7)
    assert found["ddof2"].tolist() == peer["Den DF"].tolist()


def test_sums_of_squares_add_up_to_total() -> None:
    values = drawn((5, 2, 3, 4), np.random.default_rng())
    of_errors = sum(effect.ss_error for effect in effects(design_of(values)))
    between = 24 * np.sum((values.mean(axis=(1, 2, 3)) - values.mean()) ** 2)
    parts = analysed(values)["SS"].sum() + of_errors + between
    assert parts == pytest.approx(np.sum((values - values.mean()) ** 2), rel=1e-12)


def test_eta_squared_of_three_factors_reduces_to_two() -> None:
    values = drawn((6, 3, 4), np.random.default_rng())
    three = analysed(np.repeat(values[..., None], 2, axis=-1) + np.random.default_rng().normal(0, 1e-9, (6, 3, 4, 2)))
    two = analysed(values)
    assert three["ng2"].iloc[[0, 1, 3]].to_numpy() == pytest.approx(two["ng2"].to_numpy(), rel=1e-6)


@given(st.integers(3, 12), st.integers(2, 6), st.integers(0, 2**32 - 1))
def test_epsilons_lie_between_one_over_df_and_one(n, k, seed) -> None:
    (effect,) = effects(design_of(drawn((n, k), np.random.default_rng(seed))))
    greenhouse_geisser, huynh_feldt, _ = epsilons(effect.covariance, n - 1)
    assert 1 / effect.df[0] - 1e-12 <= greenhouse_geisser <= huynh_feldt + 1e-12 <= 1 + 2e-12
    assert effect.is_singular == (k > 2 and n - 1 < k - 1)


def test_huynh_and_feldt_of_the_published_table(published_values) -> None:
    found = analysed(published_values)
    assert found["eps_HF"].to_numpy() == pytest.approx([1, 0.931837, 1], abs=1e-6)
    assert found["np2"].to_numpy() == pytest.approx([0.844862, 0.988932, 0.220564], abs=1e-6)
    corrected = fisher.sf(found["F"], found["eps_HF"] * found["ddof1"], found["eps_HF"] * found["ddof2"])
    assert found["p_HF_corr"].to_numpy() == pytest.approx(corrected, rel=1e-9)
    assert found["p_HF_corr"][1] > 2 * found["p_unc"][1]


def test_chi_muller_epsilon_shrinks_huynh_feldt_epsilon(published_values) -> None:
    """With n = 8 the factor is 25 * 23 / 27^2; the lower bound is Greenhouse and Geisser's."""
    found = analysed(published_values)
    gg, p = found["eps"].to_numpy(), found["ddof1"].to_numpy()
    wide = (8 * p * gg - 2) / (p * (7 - p * gg))
    expected = np.minimum(1, np.maximum(wide * 25 * 23 / 27**2, gg))
    assert found["eps_CM"].to_numpy() == pytest.approx(expected, rel=1e-12)
    assert (found["p_CM_corr"] >= found["p_HF_corr"] * (1 - 1e-12)).all()


@pytest.mark.parametrize(("p", "holds"), [(0.049, False), (0.051, True)])
def test_sphericity_is_rejected_at_5_percent(p, holds) -> None:
    effect = EffectTest("force", 3.0, 9.0, (2, 12), (0.8, 0.9, 0.85), mauchly=(0.5, p))
    table = effect_table([effect], residual=40.0, scale=1.0, interval=0.9)
    assert table["sphericity"][0] is holds


def test_singular_note_distinguishes_few_participants_from_dependent_contrasts() -> None:
    rng = np.random.default_rng()
    (few,) = effects(design_of(drawn((4, 5), rng)))
    assert "(4 contrasts need at least 5 complete participants, found 4)" in singular_note(few, 4)
    values = drawn((8, 3), rng)
    values[:, 2] = 2 * values[:, 0] - values[:, 1]
    (note,) = analysed(values).attrs["notes"]
    assert "(its 2 contrasts are linearly dependent in these 8 participants)" in note


@pytest.fixture
def published_values() -> np.ndarray:
    from published_design import PUBLISHED

    return np.array(PUBLISHED.split(), dtype=float).reshape(8, 3, 4)


@given(st.floats(0.01, 500), st.integers(1, 12), st.integers(4, 200))
@examples(50)
def test_noncentrality_interval_excludes_five_percent_per_side(f, first, second) -> None:
    low, high = noncentrality(f, (first, second), 0.90)
    assert low == 0 or ncf.sf(f, first, second, low) == pytest.approx(0.05, abs=1e-5)
    assert high == 0 or ncf.cdf(f, first, second, high) == pytest.approx(0.05, abs=1e-5)


def test_eta_squared_interval_excludes_zero_when_significant() -> None:
    found = [eta_squared(ss, 18.0, 40.0, (1, 18)) for ss in (4.413, 4.415)]
    assert [size["np2_low"] > 0 for size in found] == [False, True]
    assert all(size["ng2_low"] <= size["ng2"] <= size["ng2_high"] for size in found)


def test_corrected_intervals_exclude_five_percent_per_side(published_values) -> None:
    """Eta squared is l / (l + n), with n = epsilon (df1 + df2) + 1; the generalised one has other errors."""
    whole = analysed(published_values)
    found = whole[whole["p_CM_corr"] < 0.05]
    assert whole["np2_low"].to_numpy()[2] == 0
    df1, df2 = found["eps_CM"] * found["ddof1"], found["eps_CM"] * found["ddof2"]
    for end, chance in (("low", 0.95), ("high", 0.05)):
        odds = found[f"np2_{end}"] / (1 - found[f"np2_{end}"])
        assert ncf.cdf(found["F"], df1, df2, odds * (df1 + df2 + 1)) == pytest.approx([chance] * 2, abs=1e-5)
        share = found["ng2"] / (1 - found["ng2"]) * (1 - found["np2"]) / found["np2"]
        assert found[f"ng2_{end}"].to_numpy() == pytest.approx((odds * share / (1 + odds * share)).to_numpy(), rel=1e-9)


def test_all_signs_are_counted_once() -> None:
    scores = drawn((6, 3), np.random.default_rng())
    signs = np.array(list(product((-1, 1), repeat=6)))
    sums = np.array([np.sum((row @ scores) ** 2) for row in signs])
    assert permutation_p(ContrastEffect(("a",), scores)) == np.mean(sums >= sums[-1] * (1 - 1e-12))


def test_many_participants_draw_signs_and_agree_with_f() -> None:
    rng = np.random.default_rng()
    scores = rng.normal(size=(40, 2)) + 0.25
    f = 40 * np.sum(scores.mean(axis=0) ** 2) / (ContrastEffect(("a",), scores).ss_error / 39)
    found = permutation_p(ContrastEffect(("a",), scores), rng=rng, n_resamples=4000)
    assert found == pytest.approx(fisher.sf(f, 2, 78), abs=0.03)


@pytest.mark.parametrize(("n", "n_permutations"), [(6, 32), (14, 8192), (15, 99)])
def test_permutation_test_reports_number_of_permutations(n, n_permutations) -> None:
    rng = np.random.default_rng()
    names = {"dependent": "y", "within": "force", "subject": "subject"}
    found = permutation_test(long_table(drawn((n, 3), rng)), **names, rng=rng, n_resamples=99)
    assert found["n_permutations"].tolist() == [n_permutations]


def test_permutation_test_requires_generator_for_many_participants() -> None:
    table = long_table(drawn((16, 3), np.random.default_rng()))
    with pytest.raises(InvalidParameter, match=r"rng: found none for 16 participants, expected a Generator"):
        permutation_test(table, dependent="y", within="force", subject="subject")


def test_permutation_test_works_when_sphericity_is_untestable() -> None:
    values = drawn((10, 3, 7), np.random.default_rng())
    found = analysed(values)
    tested = permutation_test(long_table(values), dependent="y", within=["force", "freq"], subject="subject")
    assert found.attrs["status"] == DesignStatus.SINGULAR
    assert found["p_spher"].isna().tolist() == [False, False, True]
    assert "(12 contrasts need at least 13 complete participants, found 10)" in found.attrs["notes"][0]
    assert (tested["n_permutations"] == 512).all()
    assert tested["F"].to_numpy() == pytest.approx(found["F"].to_numpy())


VALUES = np.random.default_rng(0).normal(size=(6, 3, 4))


def test_zero_variance_between_participants_has_its_f() -> None:
    values = VALUES - VALUES.mean(axis=(1, 2), keepdims=True)
    assert analysed(values)["F"].to_numpy() == pytest.approx(analysed(VALUES)["F"].to_numpy(), rel=1e-9)


def test_three_participants_have_an_answer() -> None:
    found = analysed(VALUES[:3])
    assert found.attrs["status"] == DesignStatus.SINGULAR
    assert np.isfinite(found[["F", "p_unc", "ng2", "np2_low", "np2_high"]].to_numpy(dtype=float)).all()


N = 10
SCENARIOS = ("spherical", "AR(1)", "noisy", "no interaction")
DESIGNS: Mapping[str, tuple[tuple[int, ...], tuple[int, ...]]] = {"4": ((4,), (0,)), "3 x 4": ((3, 4), (0, 1))}


def reach(share: float, n: int) -> float:
    """Return the two-sided tolerance at 1e-4 of a share of `n` studies."""
    return float(norm.isf(0.5e-4) * np.sqrt(share * (1 - share) / n))


def null_studies(scenario: str, n_cells: int, shape: tuple[int, int], rng: np.random.Generator) -> np.ndarray:
    """Draw studies of `shape` (study, participant) without effects; participants have twice the errors' deviation."""
    places = np.arange(n_cells)
    covariance = {
        "spherical": np.eye(n_cells),
        "AR(1)": 0.7 ** np.abs(np.subtract.outer(places, places)),
        "noisy": np.diag(np.where(places == 0, 9.0, 1.0)),
        "no interaction": 1e-4 * np.eye(n_cells),
    }[scenario]
    return rng.normal(size=(*shape, n_cells)) @ np.linalg.cholesky(covariance + 4.0).T


def chi_muller_p(effect: ContrastEffect) -> float:
    (p, df), n = effect.df, len(effect.scores)
    f = n * np.sum(effect.scores.mean(axis=0) ** 2) / p / (effect.ss_error / df)
    epsilon = epsilons(effect.covariance, n - 1)[2]
    return float(fdtrc(epsilon * p, epsilon * df, f))


@pytest.mark.slow
@pytest.mark.parametrize("design", DESIGNS)
@pytest.mark.parametrize("scenario", SCENARIOS)
def test_anova_false_positive_rate_is_near_five_percent(design, scenario) -> None:
    n_levels, part = DESIGNS[design]
    n_studies = 60_000 if SOAK else 2_000
    values = null_studies(scenario, int(np.prod(n_levels)), (n_studies, N), np.random.default_rng())
    scores = values @ contrasts(n_levels, part).T
    rate = np.mean([chi_muller_p(ContrastEffect(("x",), each)) < 0.05 for each in scores])
    assert abs(rate - 0.05) < 0.01 + reach(0.06, n_studies)


@pytest.mark.slow
@pytest.mark.parametrize("scenario", SCENARIOS[:3])
def test_censored_anova_has_nominal_error_and_coverage(scenario) -> None:
    """A seventh of the values are bounds; the rates are 4 to 6 % and 94 to 98 % (docs/reference/analysis.md)."""
    n_studies = 3_000 if SOAK else 80
    values = null_studies(scenario, 4, (n_studies, N), np.random.default_rng())
    at = float(np.quantile(values[..., 1:], 0.15))
    found = [censored_anova(cut(long_table(each), at), within="force", **GIVEN) for each in values]
    rate = np.mean([each.table["p_CM_corr"][0] < 0.05 for each in found])
    assert abs(rate - 0.05) < 0.015 + reach(0.06, n_studies)
    means = [each.means() for each in found]
    held = np.mean([(each["mean_low"] < 0) & (each["mean_high"] > 0) for each in means], axis=0)
    assert (held > 0.94 - reach(0.95, n_studies)).all()
    assert (held < 0.98 + reach(0.97, n_studies)).all()


@pytest.mark.slow
@pytest.mark.parametrize("scenario", ["spherical", "noisy"])
def test_simultaneous_intervals_have_joint_coverage(scenario) -> None:
    """They exclude 0 only if Holm's p is below 5 %."""
    n_studies = 3_000 if SOAK else 100
    values = null_studies(scenario, 4, (n_studies, N), np.random.default_rng())
    tables = [pairs(long_table(each), dependent="y", factor="force", subject="subject") for each in values]
    held = [((each["simultaneous_low"] < 0) & (each["simultaneous_high"] > 0)) for each in tables]
    assert np.mean([each.all() for each in held]) > 0.95 - reach(0.95, n_studies)
    whole, of_all = pd.concat(tables), pd.concat(held)
    assert (whole.loc[~of_all.to_numpy(), "p_corr"] < 0.05).all()


@pytest.mark.slow
@pytest.mark.parametrize(("scenario", "low", "high"), [("spherical", 0.935, 0.965), ("AR(1)", 0.90, 0.99)])
def test_within_intervals_overlap_as_often_as_differences(scenario, low, high) -> None:
    """With correlated errors neighbours separate less often, as they are more alike than others."""
    n_studies = 20_000 if SOAK else 2_000
    values = null_studies(scenario, 4, (n_studies, N), np.random.default_rng())
    halves = student.ppf(0.975, N - 1) * np.sqrt([within_variances(np.cov(each.T)) / N for each in values])
    means = values.mean(axis=1)
    for first, second in ((0, 1), (0, 3)):
        meet = np.abs(means[:, first] - means[:, second]) < DIFFERENCE * (halves[:, first] + halves[:, second])
        assert low - reach(low, n_studies) < meet.mean() < high + reach(0.95, n_studies)
