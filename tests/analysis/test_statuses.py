"""Tests of statuses; the bias study has their shares (test_bias_study.py)."""

import math
from dataclasses import asdict

import numpy as np
import pytest
from examples import examples
from hard_cases import exact_case
from hypothesis import given, strategies as st

from tactometry.analysis.outcomes.hierarchical_outcome import group_fit
from tactometry.analysis.tasks.cell import Cell
from tactometry.analysis.tasks.cells import estimates
from tactometry.analysis.threshold.fitting import METHODS, Status, fit, fit_many

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
