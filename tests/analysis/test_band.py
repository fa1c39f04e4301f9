"""Tests of the posterior band of a psychometric function."""

import numpy as np
import pytest

from tactometry.analysis.threshold.band import curve_band
from tactometry.analysis.threshold.fitting import fit
from tactometry.errors import InvalidParameter
from tactometry.psychometric import PsychometricFunction

LEVELS = np.linspace(0.0, 30.0, 9)
YES_NO = {"shape": "gumbel", "guess_rate": None, "scale_free_width": True}
CHOICE = {"shape": "normal", "guess_rate": 0.5, "scale_free_width": True}


def answers(truth, n, seed):
    return np.random.default_rng(seed).binomial(n, truth.probability(LEVELS))


@pytest.mark.parametrize("options", [YES_NO, CHOICE], ids=["yes_no", "choice"])
@pytest.mark.parametrize("seed", range(3))
def test_band_draws_have_threshold_of_fit(options, seed):
    truth = PsychometricFunction(options["shape"], 14.0, 12.0, options["guess_rate"] or 0.05, 0.02)
    k = answers(truth, 12, seed)
    found = fit(LEVELS, k, 12, **options)
    band = curve_band(LEVELS, k, 12, [0.0], **options)
    # the draws stand on nodes: a step of the grid is at most a sixth of the interval
    step = (found.interval_high - found.interval_low) / 6
    assert band.threshold == pytest.approx((found.interval_low, found.threshold_median, found.interval_high), abs=step)


def test_band_narrows_around_truth_with_many_trials():
    truth = PsychometricFunction("normal", 14.0, 12.0, 0.5, 0.02)
    at = np.linspace(5.0, 25.0, 11)
    few, many = (curve_band(LEVELS, np.round(n * truth.probability(LEVELS)), n, at, **CHOICE) for n in (10, 10_000))
    assert (many.high - many.low).max() < 0.02 < (few.high - few.low).min()
    assert many.median == pytest.approx(truth.probability(at), abs=0.01)


def test_band_rises_with_level_between_zero_and_one():
    band = curve_band(LEVELS, [0, 0, 1, 2, 4, 5, 6, 6, 6], 6, np.linspace(-5.0, 35.0, 41), **YES_NO)
    for line in (band.low, band.median, band.high):
        assert (np.diff(line) >= 0).all()
        assert line.min() >= 0
        assert line.max() <= 1


def test_single_level_has_no_band():
    assert curve_band([3.0], [2], [5], [3.0], **YES_NO) is None


def test_band_rejects_invalid_interval():
    with pytest.raises(InvalidParameter, match="interval"):
        curve_band(LEVELS, 1, 2, [1.0], interval=1.0, **YES_NO)
