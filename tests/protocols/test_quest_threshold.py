"""QUEST: argument checks, impossible answers and stopping."""

import math

import numpy as np
import pytest
from hard_cases import exact_case

from tactometry.errors import InvalidParameter
from tactometry.protocols import Quest

OPTIONS = {"start": 20.0, "start_sd": 10.0, "low": 0.0, "high": 40.0, "step": 0.5}


def test_delivered_level_off_grid_is_not_rounded():
    rule = Quest(**OPTIONS)
    assert not np.array_equal(rule.after(1, delivered=20.1).posterior, rule.after(1, delivered=20.0).posterior)


def test_probability_at_threshold_equals_target():
    rule = Quest(**OPTIONS, target=0.7)
    n = int(np.flatnonzero(rule.thresholds == 20.0)[0])
    assert math.exp(rule.grid.log_likelihood(20.0, 1)[n]) == pytest.approx(0.7)


def test_run_converges_at_requested_standard_deviation():
    rng, rule = np.random.default_rng(), Quest(**OPTIONS, n_trials=500, sd_stop=1.0)
    while not rule.finished:
        rule = rule.after(bool(rng.random() < 0.5 + 0.49 / (1 + math.exp(15 - rule.level))))
    assert (rule.ending, rule.threshold_sd <= 1.0) == ("converged", True)


def test_answers_that_no_threshold_allows_end_as_aborted():
    rule = Quest(**OPTIONS, blind_share=0.0).after(0, delivered=1e6)
    assert (rule.ending, rule.threshold) == ("aborted", None)
    assert np.isfinite(rule.posterior).all()


def test_ten_thousand_answers_stay_finite():
    rule = Quest(**OPTIONS, n_trials=10**6)
    for n in range(10_000):
        rule = rule.after(n % 2, delivered=40.0 * (1 - n % 2))
    assert np.isfinite(rule.posterior).all()
    assert 0 <= rule.level <= 40
    exact_case("10 000 answers to QUEST", against="all finite")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"start": 50.0}, "Quest.start: found 50, low 0, high 40 and step 0.5, expected a start between low and high"),
        ({"start_sd": 0.0}, "Quest.start_sd: found 0.0, expected a finite number above 0"),
        ({"step": 50.0}, "Quest.start: found 20, low 0, high 40 and step 50, expected a start between low and high"),
        ({"sd_stop": 0.0}, "Quest.sd_stop: found 0.0, expected a finite number above 0"),
        ({"placing": "median"}, "Quest.placing: found 'median', expected one of quantile, mean, mode"),
        ({"guess_rate": 1.0}, "Quest.guess_rate: found 1.0, expected a number from 0 to below 1"),
        *(({"target": p}, f"Quest.target: found {p}, expected a probability between the as") for p in (0.4, 0.997)),
    ],
)
def test_impossible_numbers_are_refused(options, message):
    with pytest.raises(InvalidParameter, match=message):
        Quest(**(OPTIONS | options))
