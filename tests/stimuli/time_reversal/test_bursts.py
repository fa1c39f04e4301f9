"""Foci whose level is the length of a burst, against responses added up channel by channel."""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.signal import fftconvolve
from time_reversal_calls import SETUP

from tactometry.errors import InvalidParameter, LimitExceeded
from tactometry.stimuli.time_reversal.focusing.bursts import RESOLVED, Bursts
from tactometry.stimuli.time_reversal.focusing.pattern import PATTERNS, Pattern
from tactometry.stimuli.time_reversal.focusing.quantiser import Analogue
from tactometry.stimuli.time_reversal.responses.responses import Responses
from tactometry.stimuli.time_reversal.stimulus.focus_train import FocusTrain, TimeReversalStimulus

SUPPLY_V = 100.0


def moved_m(signal, setup):
    """Return the motion of the focus: the sum of convolved channels."""
    [heard] = setup.responses_at(*setup.focus_m).samples
    return sum(fftconvolve(drive, response) for drive, response in zip(signal.samples, heard, strict=True))


@pytest.mark.parametrize("pattern", PATTERNS)
@pytest.mark.parametrize("level", [12.0, 24.0])
def test_each_focus_has_requested_amplitude_at_one_supply(pattern, level):
    """The default screen; half of a per cent is the size of one sample of one channel at the lowest level."""
    train = FocusTrain(pattern=pattern, supply_v=SUPPLY_V)
    signal, asked_m = train.at(level), 1e-6 * 10 ** (level / 20)
    assert set(np.unique(signal.samples)) == {-SUPPLY_V, 0.0, SUPPLY_V}
    course_m = moved_m(signal, train.setup)
    instants = np.rint((train.foci.times_s + train.emission_s) * signal.rate_hz).astype(int) - 1
    np.testing.assert_allclose(course_m[instants], asked_m * train.foci.weights, atol=5e-3 * asked_m)
    assert np.abs(course_m).max() <= 1.005 * asked_m


def test_burst_drive_keeps_whole_focus_at_needed_voltage():
    by_voltage = FocusTrain(SETUP, f_max_hz=800.0, duration_s=1.0)
    needed_v = by_voltage.voltage_v(-20.0)
    switched = FocusTrain(SETUP, f_max_hz=800.0, duration_s=1.0, supply_v=needed_v * (1 + 1e-9))
    assert switched.level_max == pytest.approx(-20.0, abs=1e-6)
    whole, off = by_voltage.at(-20.0).samples, switched.at(-20.0).samples == 0
    np.testing.assert_allclose(switched.at(-20.0).samples[~off], whole[~off], rtol=1e-6)
    assert switched.voltage_v(-30.0) == switched.supply_v


@given(st.floats(0.5, 1.0), st.integers(0, 2**32 - 1))
def test_reachable_focus_is_exact_to_one_sample_step(part, seed):
    rng = np.random.default_rng(seed)
    heard = Responses(rng.normal(size=(1, 8, 60)), 1e3)
    bits = np.where(heard.samples[0, :, ::-1] >= 0, 1.0, -1.0)
    bursts = Bursts([bits], np.array([0]), heard, [0], 30.0)
    signal = bursts.drive(np.array([part * bursts.reach_m]))
    made_m = np.sum(signal.samples[:, ::-1] * heard.samples[0])
    assert abs(made_m - part * bursts.reach_m) <= 30.0 * np.abs(heard.samples).max() / 2 * (1 + 1e-9)


def test_a_moving_focus_is_made_at_each_of_its_points():
    rng = np.random.default_rng(0)
    heard = Responses(rng.normal(size=(2, 8, 100)), 1e3)
    pattern = Pattern(20.0, 0.1)
    stimulus = TimeReversalStimulus(heard, pattern, reversal_s=0.05, path=[1, 0], supply_v=30.0)
    level = 0.5 * stimulus.level_max
    signal = stimulus.at(level)
    for row, instant in ((1, 49), (0, 99)):
        lags = instant - np.arange(instant + 1)
        made_m = np.sum(signal.samples[:, : instant + 1] * heard.samples[row][:, lags])
        assert made_m == pytest.approx(level, rel=RESOLVED)


def test_level_above_burst_range_is_refused_with_fix():
    train = FocusTrain(supply_v=SUPPLY_V)
    with pytest.raises(
        LimitExceeded,
        match=r"^level: found 32.0 dB re 1 um, a focus of 39.81 um, expected one that a burst at the 100 V of the "
        r"supply makes: the nearest has 32.57 um; the largest level is about 30.2569: lower it, lengthen reversal_s, "
        r"or raise the supply$",
    ):
        train.at(32.0)
    assert train.at(train.level_max - 1e-9).peak == SUPPLY_V
    coarse = TimeReversalStimulus(Responses(np.ones((1, 1, 4)), 1e3), supply_v=1.0)
    with pytest.raises(LimitExceeded, match="found 1.5 m, a focus of 1.5e.06 um, .* the nearest has 1e.06 um"):
        coarse.at(1.5)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: FocusTrain(drive="analogue", supply_v=30.0),
         "supply_v: found 30 with an analogue drive, expected dri"),
        (lambda: TimeReversalStimulus(HEARD, quantiser=Analogue(), supply_v=30.0), "TimeReversalStimulus.supply_v"),
        (lambda: FocusTrain(supply_v=0.0), "FocusTrain.supply_v: found 0.0, expected"),
        (lambda: TimeReversalStimulus(HEARD, Pattern(20.0, 0.1), reversal_s=0.06, supply_v=30.0).at(1.0),
         "reversal_s: found 0.06 s, expected at most the 0.05 s between foci, .*; shorten it"),
    ],
)  # fmt: skip
def test_supply_voltage_is_refused_when_drive_cannot_switch(make, message):
    with pytest.raises(InvalidParameter, match=message):
        make()


HEARD = Responses(np.ones((1, 2, 100)), 1e3)
