"""Tests of statuses (the bias study has their shares) and of modes with several maxima."""

import math
from dataclasses import asdict
from itertools import product

import numpy as np
import pytest
from examples import examples
from hard_cases import exact_case
from hypothesis import given, strategies as st
from scipy.stats import binom
from soak import SOAK

from tactometry.analysis.outcomes.hierarchical_outcome import group_fit
from tactometry.analysis.tasks.cell import Cell
from tactometry.analysis.tasks.cells import estimates
from tactometry.analysis.threshold.fitting import METHODS, Status, fit, fit_many, log_posterior
from tactometry.analysis.threshold.mode import _without, climb, convex_solve, find_mode

RATES = (None, 0.0, 0.02)
OUTSIDE = (Status.BELOW, Status.ABOVE, Status.FLAT)


def test_track_at_three_quarters_correct_has_status_ok() -> None:
    """A weighted staircase: 7 % of the posterior lie below the lowest level."""
    levels_db, n_trials = [20, 22, 24, 26, 28, 30, 32, 34], [1, 4, 6, 6, 5, 5, 3, 2]
    found = fit(levels_db, [0, 2, 4, 5, 4, 5, 3, 2], n_trials, shape="gumbel", guess_rate=0.5, scale_free_width=True)
    assert found.status == Status.OK
    assert found.interval_low < 20 < found.threshold < found.interval_high
    assert found.probability_within > 0.8


def test_constant_rates_are_flat_above_or_below() -> None:
    flat, above, below = (fit(range(7), [k] * 7, 20, shape="normal", guess_rate=0.5) for k in (14, 10, 20))
    assert [one.status for one in (flat, above, below)] == [Status.FLAT, Status.ABOVE, Status.BELOW]
    assert above.probability_above > 0.8
    assert below.probability_below > 0.8
    assert sum((above.probability_below, above.probability_within, above.probability_above)) <= 1


ANSWERS = ((0, 3, 7, 10), (1, 1, 2, 2), (10, 10, 9, 10), (3, 6, 8, 10), (4, 4, 5, 4))


@pytest.mark.parametrize(
    "catch", [(1, 20), pytest.param((8, 20), marks=pytest.mark.slow), (0, 0)], ids=["few alarms", "many", "no catch"]
)
def test_hierarchical_statuses_equal_single_statuses(catch) -> None:
    levels = (1.0, 2.0, 3.0, 4.0)
    cells = [Cell(f"P{i}", (), "yes_no", levels, k, (10,) * 4, *catch[::-1]) for i, k in enumerate(ANSWERS)]
    alone = [each.fit.status for each in estimates(cells, "dB")]
    options = {"shape": "gumbel", "guess_rate": None, "scale_free_width": True}
    options |= {"n_false_alarms": catch[0], "n_catch": catch[1]}
    assert alone == [fit(levels, k, 10, **options).status for k in ANSWERS]
    assert group_fit(cells, (), "dB").participants["status"].tolist() == alone


@st.composite
def _nasty(draw: st.DrawFn) -> tuple[list[float], list[int], list[int]]:
    """Draw a few levels, close or far apart, with few or very many answers in any order."""
    size = draw(st.integers(2, 7))
    gaps = draw(st.lists(st.sampled_from((0.001, 0.1, 1.0, 60.0)), min_size=size, max_size=size))
    n_trials = draw(st.lists(st.sampled_from((1, 2, 5, 20, 200)), min_size=size, max_size=size))
    n_yes = [draw(st.one_of(st.sampled_from((0, n)), st.integers(0, n))) for n in n_trials]
    return np.cumsum(gaps).tolist(), n_yes, n_trials


@pytest.mark.parametrize("method", METHODS)
@examples(25, deadline=None)
@given(_nasty(), st.sampled_from((None, 0.0, 0.5, 0.25)), st.sampled_from(RATES), st.booleans())
def test_every_estimate_is_within_its_interval(method, data, guess_rate, lapse_rate, scale_free_width) -> None:
    known = {"guess_rate": guess_rate, "lapse_rate": lapse_rate, "scale_free_width": scale_free_width}
    found = fit_many(*data, shape="normal", method=method, **known)[0]
    numbers = {name: value for name, value in asdict(found).items() if isinstance(value, float)}
    assert all(math.isfinite(value) for value in numbers.values())
    if found.threshold is not None:
        assert found.status not in OUTSIDE
    if found.threshold is not None and found.method == "posterior":
        assert found.interval_low < found.threshold < found.interval_high
    if found.width is not None and found.method == "posterior":
        assert 0 < found.width_low <= found.width <= found.width_high < 1e4 * found.width_low


def test_likelihood_without_curvature_has_status_and_posterior_interval() -> None:
    """Regression test: maximum likelihood printed widths from 3.6e-93 to 2.7e91."""
    found = fit(range(1, 8), [11, 10, 13, 12, 12, 13, 14], 20, shape="normal", guess_rate=0.5, method="likelihood")
    assert found.status == Status.FLAT
    assert (found.threshold, found.width_high, found.method) == (None, None, "posterior")


def test_all_three_estimates_are_available() -> None:
    answers = ([1, 2, 3, 4, 5, 6, 7], [10, 11, 12, 15, 18, 19, 20], 20)
    fits = {name: fit(*answers, shape="normal", guess_rate=0.5, estimate=name) for name in ("mode", "median", "mean")}
    for name, one in fits.items():
        assert one.threshold == getattr(fits["mode"], f"threshold_{name}")
    assert fits["mean"].threshold < fits["median"].threshold < fits["mode"].threshold


@pytest.mark.parametrize("n_yes", [[4, 4, 6, 6, 6, 6, 5], [6, 6, 3, 5, 7, 9, 6]])
def test_noisy_half_yes_answers_are_flat(n_yes) -> None:
    """The interval, twice as long as the levels, is not informative."""
    found = fit(range(7), n_yes, 10, shape="normal", guess_rate=0.0, method="likelihood")
    assert found.status == Status.FLAT


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("n", [12, 100_000])
def test_half_yes_answers_are_flat_for_any_size(n, method) -> None:
    """The prior of the width alone would place the threshold at the middle."""
    found = fit(range(7), [n // 2] * 7, n, shape="normal", guess_rate=0.0, lapse_rate=0.0, method=method)
    assert (found.status, found.threshold) == (Status.FLAT, None)
    exact_case("half of the answers yes at every level", against="a status, no number")


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
