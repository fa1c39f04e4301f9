"""Tests of simulated error rates of F and coverage of intervals; tolerances are standard errors at 1e-4."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
import pytest
from designs import long_table
from open_ends import GIVEN, cut
from scipy.special import fdtrc
from scipy.stats import norm, t as student
from soak import SOAK

from tactometry.analysis.anova.censored import censored_anova
from tactometry.analysis.anova.contrasts import ContrastEffect, contrasts, epsilons
from tactometry.analysis.anova.group_means import DIFFERENCE, within_variances
from tactometry.analysis.anova.post_hoc import pairs

pytestmark = pytest.mark.slow

N = 10
SCENARIOS = ("spherical", "AR(1)", "noisy", "no interaction")
DESIGNS: Mapping[str, tuple[tuple[int, ...], tuple[int, ...]]] = {"4": ((4,), (0,)), "3 x 4": ((3, 4), (0, 1))}


def reach(share: float, n: int) -> float:
    """Return the two-sided tolerance at 1e-4 of a share of `n` studies."""
    return float(norm.isf(0.5e-4) * np.sqrt(share * (1 - share) / n))


def drawn(scenario: str, n_cells: int, shape: tuple[int, int], rng: np.random.Generator) -> np.ndarray:
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


@pytest.mark.parametrize("design", DESIGNS)
@pytest.mark.parametrize("scenario", SCENARIOS)
def test_anova_false_positive_rate_is_near_five_percent(design, scenario) -> None:
    """Use ten participants and Chi and Muller's p of the highest effect."""
    n_levels, part = DESIGNS[design]
    n_studies = 60_000 if SOAK else 2_000
    values = drawn(scenario, int(np.prod(n_levels)), (n_studies, N), np.random.default_rng())
    scores = values @ contrasts(n_levels, part).T
    rate = np.mean([chi_muller_p(ContrastEffect(("x",), each)) < 0.05 for each in scores])
    assert abs(rate - 0.05) < 0.01 + reach(0.06, n_studies)


@pytest.mark.parametrize("scenario", SCENARIOS[:3])
def test_censored_anova_has_nominal_error_and_coverage(scenario) -> None:
    """A seventh of the values are bounds; the rates are 4 to 6 % and 94 to 98 % (docs/reference/analysis.md)."""
    n_studies = 3_000 if SOAK else 80
    values = drawn(scenario, 4, (n_studies, N), np.random.default_rng())
    at = float(np.quantile(values[..., 1:], 0.15))
    found = [censored_anova(cut(long_table(each), at), within="force", **GIVEN) for each in values]
    rate = np.mean([each.table["p_CM_corr"][0] < 0.05 for each in found])
    assert abs(rate - 0.05) < 0.015 + reach(0.06, n_studies)
    means = [each.means() for each in found]
    held = np.mean([(each["mean_low"] < 0) & (each["mean_high"] > 0) for each in means], axis=0)
    assert (held > 0.94 - reach(0.95, n_studies)).all()
    assert (held < 0.98 + reach(0.97, n_studies)).all()


@pytest.mark.parametrize("scenario", ["spherical", "noisy"])
def test_simultaneous_intervals_have_joint_coverage(scenario) -> None:
    """They exclude 0 only if Holm's p is below 5 %."""
    n_studies = 3_000 if SOAK else 100
    values = drawn(scenario, 4, (n_studies, N), np.random.default_rng())
    tables = [pairs(long_table(each), dependent="y", factor="force", subject="subject") for each in values]
    held = [((each["simultaneous_low"] < 0) & (each["simultaneous_high"] > 0)) for each in tables]
    assert np.mean([each.all() for each in held]) > 0.95 - reach(0.95, n_studies)
    whole, of_all = pd.concat(tables), pd.concat(held)
    assert (whole.loc[~of_all.to_numpy(), "p_corr"] < 0.05).all()


@pytest.mark.parametrize(("scenario", "low", "high"), [("spherical", 0.935, 0.965), ("AR(1)", 0.90, 0.99)])
def test_within_intervals_overlap_as_often_as_differences(scenario, low, high) -> None:
    """With correlated errors neighbours separate less often, as they are more alike than others."""
    n_studies = 20_000 if SOAK else 2_000
    values = drawn(scenario, 4, (n_studies, N), np.random.default_rng())
    halves = student.ppf(0.975, N - 1) * np.sqrt([within_variances(np.cov(each.T)) / N for each in values])
    means = values.mean(axis=1)
    for first, second in ((0, 1), (0, 3)):
        meet = np.abs(means[:, first] - means[:, second]) < DIFFERENCE * (halves[:, first] + halves[:, second])
        assert low - reach(low, n_studies) < meet.mean() < high + reach(0.95, n_studies)
