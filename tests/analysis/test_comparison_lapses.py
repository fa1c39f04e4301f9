"""Tests of just noticeable differences of participants who lapse (in full: the soak, docs/reference/analysis.md).

Tolerances are standard errors at 1e-4.
"""

import numpy as np
import pandas as pd
import pytest
from scipy.stats import binom
from soak import SOAK

from tactometry.analysis.tasks.comparison import FIT
from tactometry.analysis.threshold.counts import count_arrays, normalise
from tactometry.analysis.threshold.fitting import fit
from tactometry.analysis.threshold.log_posterior import LogPosterior, Prior
from tactometry.analysis.threshold.mode import climb, find_mode
from tactometry.analysis.threshold.posterior import marginals
from tactometry.analysis.threshold.shared_grid import batched_marginals
from tactometry.errors import InvalidParameter
from tactometry.experiments.bias_study.comparisons import (
    LEVELS,
    PEOPLE,
    WITHOUT_LAPSES,
    Person,
    answers,
    outcomes_of,
    summary,
)
from tactometry.psychometric import shape_named

LEAST, MOST = 0.935, 0.97
"""Asked of the coverage of 95 % intervals of the difference."""
NORMAL = shape_named("normal")
EQUAL = {**FIT, "equal_asymptotes": True, "lapse_beta": 80.0}


@pytest.fixture(scope="module")
def found() -> pd.DataFrame:
    n_sets = 2000 if SOAK else 150
    return summary(pd.concat(outcomes_of(PEOPLE, n_sets, np.random.default_rng()))).set_index("quantity")


@pytest.mark.slow
@pytest.mark.parametrize(("quantity", "least", "most"), [("difference", LEAST, MOST), ("equality", 0.93, 1.0)])
def test_comparison_intervals_have_stated_coverage(found, quantity, least, most) -> None:
    covered, n = (found["covered"] * found["n"])[quantity], found["n"][quantity]
    assert (covered >= binom.ppf(1e-4, n, least)).all()
    assert (covered <= binom.ppf(1 - 1e-4, n, most)).all()
    assert binom.ppf(1e-4, n.sum(), LEAST) <= covered.sum() <= binom.ppf(1 - 1e-4, n.sum(), MOST)


def test_fit_without_lapses_fails_at_three_percent() -> None:
    outcomes = pd.concat(outcomes_of([Person(2.5, 40, 0.03)], 300, np.random.default_rng(), WITHOUT_LAPSES))
    difference = summary(outcomes).set_index("quantity").loc["difference"]
    assert difference["covered"] * difference["n"] < binom.ppf(1e-4, difference["n"], LEAST)


@pytest.mark.slow
def test_lapses_change_differences_by_under_a_fifth(found) -> None:
    assert found["over_truth"]["difference"].between(0.8, 1.2).all()


@pytest.fixture(scope="module")
def some() -> LogPosterior:
    n_more = answers(Person(2.5, 20, 0.05), 12, np.random.default_rng(7))[1]
    counts = normalise(*count_arrays(LEVELS, n_more, 20))
    nothing = np.zeros(len(counts))
    known = {name: value for name, value in EQUAL.items() if name != "shape"}
    return LogPosterior(NORMAL, counts, Prior(counts.gap, None, n_false_alarms=nothing, n_catch=nothing, **known))


def test_mode_with_equal_asymptotes_is_highest(some) -> None:
    mode = find_mode(some)
    assert (mode.theta[:, 2] == mode.theta[:, 3]).all()
    rng = np.random.default_rng(1)
    for _ in range(50):
        near = some.prior.tied(mode.theta + rng.normal(0, [0.02, 0.05, 0.005, 1.0], mode.theta.shape))
        near = np.clip(near, [-1, -9, 0, 0], [1, 1, 0.5, 0.5])
        assert (some.log_density(near) <= mode.log_density + 1e-9).all()
    again = climb(some, np.tile([0.1, -0.5, 0.1, 0.3], (len(some), 1)))
    assert (again.log_density <= mode.log_density + 1e-9).all()


def test_shared_and_single_grids_agree_with_sum(some) -> None:
    mode = find_mode(some)
    shared, own = (f(some, mode, 0.95) for f in (batched_marginals, marginals))
    m, v = np.linspace(-0.4, 0.4, 41), np.linspace(np.log(0.2), np.log(3.0), 80)
    rate = (np.arange(60) + 0.5) / 60 * 0.15
    nodes = np.stack(np.meshgrid(m, v, rate, [0.0], indexing="ij"), axis=-1).reshape(-1, 4)
    one = some[np.zeros(len(nodes), dtype=int)]
    mass = np.exp(one.log_density(some.prior.tied(nodes)))
    mean = np.array([mass @ nodes[:, 0], mass @ np.exp(nodes[:, 1]), mass @ nodes[:, 2]]) / mass.sum()
    for each in (shared, own):
        assert each.mean[0, :3] == pytest.approx(mean, rel=2e-3, abs=2e-4)
        assert (each.mean[:, 2] == each.mean[:, 3]).all()
    assert shared.width == pytest.approx(own.width, rel=5e-3)


def test_reversed_answers_have_same_difference() -> None:
    """Swap "more" and "less" and negate the levels: no end is preferred."""
    n_more = np.array([1, 2, 5, 9, 16, 19, 18])
    one, other = fit(LEVELS, n_more, 20, **EQUAL), fit(LEVELS, (20 - n_more)[::-1], 20, **EQUAL)
    assert other.threshold == pytest.approx(-one.threshold, abs=1e-6)
    for name in ("width", "width_low", "width_high"):
        assert getattr(other, name) == pytest.approx(getattr(one, name), rel=1e-3)
    assert one.guess_rate == one.lapse_rate


def test_equal_asymptotes_reject_known_rates_and_catch_trials() -> None:
    for known in ({"guess_rate": 0.5}, {"lapse_rate": 0.01}, {"n_catch": 3}):
        with pytest.raises(InvalidParameter, match="^equal_asymptotes: found "):
            fit(LEVELS, [0, 0, 1, 5, 9, 10, 10], 10, **EQUAL | known)
