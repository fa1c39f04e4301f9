"""Patterns of foci, the stimulus that a protocol plays, and levels by the length of a burst."""

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.signal import fftconvolve
from time_reversal_parts import SETUP

from tactometry.errors import LimitExceeded
from tactometry.stimuli.time_reversal.focusing.bursts import RESOLVED, Bursts
from tactometry.stimuli.time_reversal.focusing.focusing import drive, emitted, focus_amplitude
from tactometry.stimuli.time_reversal.focusing.one_bit import OneBit
from tactometry.stimuli.time_reversal.focusing.pattern import (
    PATTERNS,
    Exponential,
    Pattern,
    RaisedCosine,
    Rectangular,
    Sinc,
    Table,
    burst_s,
    focus_samples,
    pattern_drive,
)
from tactometry.stimuli.time_reversal.focusing.quantiser import Analogue
from tactometry.stimuli.time_reversal.responses.responses import Responses, impulse_responses
from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE
from tactometry.stimuli.time_reversal.stimulus.focus_train import FocusTrain, TimeReversalStimulus

RATE_HZ = 60e3


@pytest.fixture(scope="module")
def focus() -> Responses:
    points = [(0.12, 0.09), (0.2, 0.14)]
    return impulse_responses(A4_PROTOTYPE, points, rate_hz=RATE_HZ, duration_s=4e-3, f_max_hz=20e3)


def test_p0_is_one_focus(focus):
    signal = pattern_drive(focus, PATTERNS["P0"], 30.0)
    assert np.array_equal(signal.samples, drive(focus.at_point(0), 30.0).samples)


@pytest.mark.parametrize(("name", "n_foci"), [("P1", 10), ("P2", 10), ("P3", 10), ("P4", 25), ("P5", 25), ("P6", 25)])
def test_structure_of_p1_to_p6(name, n_foci):
    pattern = PATTERNS[name]
    assert pattern.n_foci == n_foci
    assert np.abs(pattern.weights).max() == 1.0
    assert pattern.repetition_hz == (200.0 if name in {"P1", "P2", "P3"} else 500.0)


def test_foci_match_times_and_weights_of_pattern(focus):
    """Without overlap each focus is the single one, plus the rest of the trains before."""
    pattern = Pattern(200.0, 50e-3, Exponential())
    signal = pattern_drive(focus, pattern, 30.0)
    u = emitted(signal, focus.at_point(0))[0][focus_samples(pattern, RATE_HZ, focus.n_samples)]
    alone = focus_amplitude(drive(focus.at_point(0), 30.0), focus)
    assert u[0] == pytest.approx(alone * pattern.weights[0], rel=1e-12)
    assert u == pytest.approx(alone * pattern.weights, abs=0.1 * alone)


def test_overlapping_drives_keep_the_voltage_and_lose_amplitude(focus):
    pattern = Pattern(1000.0, 20e-3)
    signal = pattern_drive(focus.at_point(0), pattern, 30.0)
    assert signal.peak == 30.0
    u = emitted(signal, focus.at_point(0))[0][focus_samples(pattern, RATE_HZ, focus.n_samples)]
    alone = focus_amplitude(drive(focus.at_point(0), 30.0), focus)
    assert 0.3 < np.median(u) / alone < 0.9


@pytest.mark.parametrize("quantiser", [OneBit(), Analogue()])
def test_overlapping_drives_keep_their_envelope(focus, quantiser):
    """The supply follows the envelope, where the sign of a sum would forget it."""
    pattern = Pattern(400.0, 20e-3, Exponential(0.3))
    signal = pattern_drive(focus.at_point(0), pattern, 30.0, quantiser)
    assert signal.peak == pytest.approx(30.0)
    u = emitted(signal, focus.at_point(0))[0][focus_samples(pattern, RATE_HZ, focus.n_samples)]
    assert np.corrcoef(u, pattern.weights)[0, 1] > 0.9
    assert u[-1] < 0.3 * u.max()


def test_burst_modulation_keeps_voltage_and_reaches_weight(focus):
    long = impulse_responses(A4_PROTOTYPE, [(0.12, 0.09)], rate_hz=RATE_HZ, duration_s=7e-3, f_max_hz=25e3)
    table = Pattern(100.0, 40e-3, Table((1.0, 0.5, -0.25, -0.75)))
    signal = pattern_drive(long, table, 30.0, modulation="burst", tau_s=3.5e-3)
    assert set(np.unique(np.abs(signal.samples))) == {0.0, 30.0}
    u = emitted(signal, long)[0][focus_samples(table, RATE_HZ, long.n_samples)]
    assert u / u[0] == pytest.approx(table.weights / table.weights[0], abs=0.08)


@given(st.floats(0.01, 1.0), st.floats(1e-3, 2e-2), st.floats(1e-3, 2e-2))
def test_burst_length_inverts_the_growth_law(weight, reversal, tau):
    short = burst_s(weight, reversal, tau)
    assert -math.expm1(-short / tau) == pytest.approx(weight * -math.expm1(-reversal / tau), rel=1e-9)


def test_a_moving_focus_visits_its_places(focus):
    pattern = Pattern(200.0, 20e-3)
    path = [0, 1, 0, 1]
    signal = pattern_drive(focus, pattern, 30.0, path=path)
    u = emitted(signal, focus)[:, focus_samples(pattern, RATE_HZ, focus.n_samples)]
    for k, row in enumerate(path):
        assert u[row, k] > 4 * abs(u[1 - row, k])


def test_envelopes():
    middle, edge = np.array([0.5]), np.array([0.0])
    assert Rectangular().at(middle) == 1.0
    assert RaisedCosine().at(edge) == 0.0
    assert RaisedCosine().at(middle) == pytest.approx(1.0)
    assert Exponential(0.5).at(np.array([1.0])) == pytest.approx(math.exp(-2))
    zeros = 0.5 + np.array([1, 2, 3]) / 6
    assert Sinc(3).at(zeros) == pytest.approx(0.0, abs=1e-15)
    assert Sinc(3).at(middle) == 1.0
    lobe = np.array([0.5 + 1.5 / 6])
    assert Sinc(3).at(lobe) < 0 < Sinc(3, signed=False).at(lobe)
    assert Table((0.0, 1.0)).at(np.array([0.25])) == 0.25


def test_envelope_is_sampled_at_middle_of_each_focus():
    assert Pattern(200.0, 20e-3, Table((0.0, 1.0))).weights == pytest.approx(np.array([1, 3, 5, 7]) / 7)
    for envelope in (Sinc(), RaisedCosine()):
        weights = Pattern(200.0, 50e-3, envelope).weights
        assert weights == pytest.approx(weights[::-1])


@pytest.mark.parametrize("name", ["P0", "P2", "P6"])
@pytest.mark.parametrize("quantiser", [None, Analogue()])
def test_stimulus_delivers_its_level(focus, name, quantiser):
    stimulus = TimeReversalStimulus(focus.at_point(0), PATTERNS[name], quantiser, voltage_max_v=1e3)
    signal = stimulus.at(2e-6)
    instants = focus_samples(PATTERNS[name], RATE_HZ, focus.n_samples)
    assert np.abs(emitted(signal, focus.at_point(0))[0, instants]).max() == pytest.approx(2e-6, rel=1e-9)
    assert signal.peak == pytest.approx(stimulus.voltage_v(2e-6), rel=1e-12)


def test_level_is_amplitude_of_largest_negative_focus():
    h = Responses(1e-9 * np.array([[[3.0, -2.0, 1.0]]]), 1e3)
    pattern = Pattern(50.0, 0.04, Table((0.6, -1.0)))
    stimulus = TimeReversalStimulus(h, pattern)
    heard = emitted(stimulus.at(1e-7), h)[0, focus_samples(pattern, 1e3, 3)]
    assert heard[1] == pytest.approx(-1e-7)
    assert 0 < heard[0] < 1e-7


def test_levels_in_decibels(focus):
    stimulus = TimeReversalStimulus(focus.at_point(0), level_unit="dB re 1 um", voltage_max_v=30.0)
    assert stimulus.voltage_v(6.0) / stimulus.voltage_v(0.0) == pytest.approx(10 ** (6 / 20))
    assert stimulus.voltage_v(stimulus.level_max) == pytest.approx(30.0)


def test_stimulus_refuses_more_than_the_amplifier_has(focus):
    stimulus = TimeReversalStimulus(focus.at_point(0), voltage_max_v=30.0)
    assert stimulus.at(stimulus.level_max).peak == pytest.approx(30.0)
    with pytest.raises(LimitExceeded, match=r"level: found .* m, which needs .* V, above the 30 V of the amplifier"):
        stimulus.at(1.01 * stimulus.level_max)


def test_default_prototype_makes_10_um_at_30_v():
    """The moment of the patch is tuned to this (unverified default): 0.2-60 kHz, T = 7 ms, one bit."""
    h = impulse_responses(A4_PROTOTYPE, [(0.12, 0.09)], rate_hz=250e3, duration_s=7e-3, f_max_hz=60e3)
    assert focus_amplitude(drive(h, 30.0), h) == pytest.approx(10e-6, rel=0.15)


def test_the_whole_weight_takes_the_whole_reversal():
    assert burst_s(1.0, 7e-3, 1e-6) == 7e-3
    assert burst_s(0.0, 7e-3, 3e-3) == 0.0


MOVING = Responses(1e-9 * np.random.default_rng(0).standard_normal((2, 3, 40)), 1e3)


@pytest.mark.parametrize("modulation", ["voltage", "burst"])
def test_moving_focus_level_is_its_largest_amplitude(modulation):
    pattern = Pattern(10.0, 0.4, Table((0.5, 1.0)))
    stimulus = TimeReversalStimulus(MOVING, pattern, path=(0, 1, 0, 1), modulation=modulation, tau_s=0.02)
    level = 0.5 * stimulus.level_max
    moved = np.abs(emitted(stimulus.at(level), MOVING)[[0, 1, 0, 1], focus_samples(pattern, 1e3, 40)])
    assert moved.max() == pytest.approx(level, rel=1e-12)
    assert moved[3] > moved[1]


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
