"""Tests of the mode of a density with several maxima."""

from itertools import product

import numpy as np
import pytest
from hard_cases import exact_case
from scipy.stats import binom
from soak import SOAK

from tactometry.analysis.threshold.fitting import fit, log_posterior
from tactometry.analysis.threshold.mode import _without, climb, convex_solve, find_mode

LEVELS = np.linspace(-3, 3, 7)
STEEP_WITH_LAPSES = np.array(np.meshgrid(np.linspace(-0.5, 0.5, 41), [-1.3, -1.15, -1.0], np.linspace(0.02, 0.48, 24)))


@pytest.mark.parametrize(
    ("k", "guess_rate"),
    [
        ([20, 23, 38, 34, 33, 32, 40], 0.5),
        ([0, 2, 18, 19, 19, 20, 16], 0.0),
        ([1, 0, 18, 29, 18, 22, 35], None),
        ([0, 17, 22, 24, 20, 25, 30], None),
    ],
    ids=str,
)
def test_mode_is_higher_of_two_summits(k, guess_rate) -> None:
    """The best node of the coarse grid leads to the lower maximum."""
    posterior = log_posterior(LEVELS, [k], 40, guess_rate=guess_rate)
    m, v, lapse = (part.ravel() for part in STEEP_WITH_LAPSES)
    nodes = np.stack([m, v, lapse, np.full_like(m, guess_rate or 0.0)], axis=1)
    found = find_mode(posterior)
    steep = max(posterior.log_density(node[None])[0] for node in nodes)
    assert found.log_density[0] >= steep
    shallow = climb(posterior, np.array([[0.0, 0.3, 0.01, guess_rate or 0.01]]))
    assert found.log_density[0] > shallow.log_density[0] + 1


@pytest.mark.parametrize(
    ("k", "threshold", "lapse_rate"),
    [([10, 11, 9, 13, 17, 18, 19], 4.7544, 0.0), ([8, 12, 17, 16, 18, 20, 17], 2.7524, 0.0737)],
)
def test_mode_is_highest_over_lapse_rates(k, threshold, lapse_rate) -> None:
    """The modes are those of psignifit 4.3; another maximum is lower by 0.01 or 0.06."""
    found = fit(range(1, 8), k, 20, shape="normal", guess_rate=0.5)
    assert (found.threshold, found.lapse_rate) == pytest.approx((threshold, lapse_rate), abs=1e-3)


def test_modes_in_a_batch_equal_single_modes() -> None:
    k = np.array([[0, 2, 18, 19, 19, 20, 16], [0, 3, 9, 21, 30, 37, 40], [0, 0, 2, 14, 18, 24, 18]])
    posterior = log_posterior(LEVELS, k, 40, guess_rate=0.0)
    together = find_mode(posterior)
    for i in range(3):
        alone = find_mode(posterior[i : i + 1])
        assert together.theta[i] == pytest.approx(alone.theta[0], abs=1e-9)
        assert together.log_density[i] == pytest.approx(alone.log_density[0], abs=1e-9)


@pytest.mark.parametrize("place", [(0, 0), (0, 1)])
def test_infinite_curvature_gives_nan_without_warning(place) -> None:
    curvature = np.tile(np.eye(4), (2, 1, 1))
    curvature[1][place] = np.inf
    matrix = _without(curvature, np.zeros((2, 4), dtype=bool))
    finite, infinite = convex_solve(matrix, np.ones((2, 4)), np.zeros(2))
    assert np.isfinite(finite).all()
    assert np.isnan(infinite).all()


# Answers of no psychometric function: the share of sets in which the highest of many summits is found
def unruly(kind, shape, rng) -> np.ndarray:
    """Chances (n_sets, n_levels): any, a random walk, or a rise with drops."""
    if kind == "any":
        return rng.uniform(0, 1, shape)
    walk = np.clip(0.2 + np.cumsum(rng.normal(0.1, 0.25, shape), axis=1), 0, 1)
    if kind == "walk":
        return walk
    rise = 1 / (1 + np.exp(-(np.arange(shape[1]) - shape[1] / 2 - rng.uniform(-2, 2, (shape[0], 1)))))
    return np.where(rng.random(shape) < 0.25, rng.uniform(0, 1, shape), rise)


SPACINGS = ((np.linspace(-3, 3, 7), 20), (np.geomspace(1, 64, 9), 10), (np.array([-3, -1.4, -1.2, 0, 0.9, 2.8, 3]), 40))
UNRULY = list(product(("any", "walk", "drops"), SPACINGS, (0.5, 0.0, None)))


def climbed_from_everywhere(posterior) -> np.ndarray:
    """The highest summits (n_sets,) from a dense grid of starts."""
    counts, prior = posterior.counts, posterior.prior
    rates = [(0.002, 0.1, 0.3) if rate is None else (rate,) for rate in (prior.lapse_rate, prior.guess_rate)]
    finest = (21, 12) if SOAK else (9, 6)
    widths = np.linspace(np.log(max(1.02 * counts.gap[0], 0.01)), np.log(2.9), finest[1])
    starts = np.array(list(product(np.linspace(-0.99, 0.99, finest[0]), widths, *rates)))
    each = np.repeat(np.arange(len(counts)), len(starts))
    found = climb(posterior[each], np.tile(starts, (len(counts), 1)))
    return found.log_density.reshape(len(counts), -1).max(axis=1)


@pytest.mark.slow
def test_highest_summit_is_found_in_irregular_sets() -> None:
    """Compare with climbs from a dense grid of starts (3 600 sets in the soak)."""
    rng, n, missed = np.random.default_rng(), 200 if SOAK else 3, 0
    for kind, (levels, n_trials), guess_rate in UNRULY:
        shape = rng.choice(["normal", "logistic", "gumbel", "reversed_gumbel"])
        k = rng.binomial(n_trials, unruly(kind, (n, len(levels)), rng))
        posterior = log_posterior(levels, k, n_trials, shape=str(shape), guess_rate=guess_rate)
        for part in (slice(start, start + 20) for start in range(0, n, 20)):
            highest = climbed_from_everywhere(posterior[part])
            missed += int(np.sum(find_mode(posterior[part]).log_density < highest - 1e-4))
    assert missed <= binom.ppf(1 - 1e-4, n * len(UNRULY), 1e-3)
    exact_case("the highest of several summits", against="climbs from everywhere, 99.9 %")
