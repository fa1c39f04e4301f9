"""Peaks and limits after a reconstruction filter, against a dense sum of sincs."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st
from hypothesis.extra.numpy import arrays

from tactometry.arguments.require import UNLIMITED
from tactometry.errors import LimitExceeded
from tactometry.safety import reconstruction
from tactometry.safety.limits import Limits
from tactometry.safety.load import Load
from tactometry.safety.reconstruction import N_PHASES, ROUNDING, TOLERANCE, course_peak
from tactometry.signal import Signal

RATE_HZ = 1000.0
N_POINTS, N_AROUND = 48, 40
"""Points per sample of the dense sum, and samples before and after the signal."""
FINGER = Load("electrode", capacitance_f=2e-9, leak_resistance_ohm=5e6)
PATCHES = Load("piezo", capacitance_f=1e-8, displacement_m_per_v=(1e-7, 3e-7))
LIMITS = Limits(1e6, current_peak_a=1e6, charge_peak_c=1e6, duration_s=60.0, duty=1.0, session_s=1e6)
MISSED = 2.5e-3
"""Relative: the tolerance of the limits, and what lies between the points of both computations."""

volts = arrays(np.float64, st.tuples(st.just(2), st.integers(1, 30)), elements=st.floats(-100, 100))
part = st.floats(0.2, 2.0)


def dense(samples):
    """Return times in samples, the filtered courses, and their change per sample."""
    n = samples.shape[-1]
    at = np.arange(-N_AROUND * N_POINTS, (n + N_AROUND) * N_POINTS) / N_POINTS
    lags = at[:, None] - np.arange(n)
    change = np.divide(np.cos(np.pi * lags) - np.sinc(lags), lags, out=np.zeros_like(lags), where=lags != 0)
    return at, samples @ np.sinc(lags).T, samples @ change.T


def peaks(samples):
    """Compute the peak of each limited quantity independently."""
    at, course, change = dense(samples)
    around = np.pad(samples, ((0, 0), (1, 1)))
    passed = np.cumsum((around[:, 1:] + around[:, :-1]) / 2, axis=1) / RATE_HZ / FINGER.leak_resistance_ohm
    lines = np.array([np.interp(at, np.arange(-1, samples.shape[1] + 1), np.append(0.0, each)) for each in passed])
    return {
        "voltage_peak_v": np.abs(course).max(),
        "current_peak_a": np.abs(FINGER.capacitance_f * RATE_HZ * change + course / FINGER.leak_resistance_ohm).max(),
        "charge_peak_c": np.abs(FINGER.capacitance_f * course + lines).max(),
        "displacement_peak_m": np.abs(course).max(axis=1) @ PATCHES.displacement_m_per_v,
    }


def verdict(samples, name, limit, load=FINGER):
    """Return the message of the refusal, or an empty text."""
    load = PATCHES if name == "displacement_peak_m" else load
    try:
        replace(LIMITS, **{name: limit}).check_filtered(Signal(samples, RATE_HZ, "V"), load)
    except LimitExceeded as error:
        return str(error)
    return ""


@pytest.mark.parametrize("name", ["voltage_peak_v", "current_peak_a", "charge_peak_c", "displacement_peak_m"])
@given(samples=volts, part=part)
def test_limits_apply_between_samples(name, samples, part):
    samples = samples.round(6)
    peak = peaks(samples)[name]
    if peak == 0.0:
        assert verdict(samples, name, 1e-12) == ""
        return
    found = verdict(samples, name, part * peak)
    if part < 1 - MISSED:
        assert found.startswith(
            f"limits.{name}: found between two samples, after the reconstruction filter, a peak of "
        )
    elif part > 1 + MISSED:
        assert found == ""


@pytest.mark.parametrize("name", ["voltage_peak_v", "current_peak_a", "charge_peak_c", "displacement_peak_m"])
def test_limits_between_samples_are_as_tight_as_stated(name):
    samples = np.random.default_rng(3).uniform(-100, 100, (2, 400))
    peak = peaks(samples)[name]
    assert verdict(samples, name, peak * (1 - 2 * TOLERANCE)) != ""
    assert verdict(samples, name, peak * (1 + TOLERANCE)) == ""


def test_refusal_between_samples_names_peak_and_remedy():
    samples = 200 * np.sqrt(2) * np.sin(np.pi / 2 * np.arange(4000) + np.pi / 4) * np.hanning(4000)
    with pytest.raises(LimitExceeded) as refusal:
        Limits(200.0).check_filtered(Signal(samples[None], RATE_HZ, "V"), None)
    assert str(refusal.value) == (
        "limits.voltage_peak_v: found between two samples, after the reconstruction filter, a peak of 282.843 V, the "
        "limit is 200 V; smooth steps and high frequencies of the signal, or lower the level; nothing was played"
    )


@pytest.mark.parametrize("frequency_hz", [50.0, 250.0, 1000.0, 5000.0])
@pytest.mark.parametrize("ramp_s", [0.0, 0.02])
def test_smooth_tone_at_the_limit_is_played(frequency_hz, ramp_s):
    """At 50 and 250 Hz, an onset rings by less than the tolerance."""
    at_s = np.arange(48_000) / 48e3
    ramp = np.clip(np.minimum(at_s, at_s[::-1]) / ramp_s, 0, 1) if ramp_s else 1.0
    tone = Signal((200 * np.sin(2 * np.pi * frequency_hz * at_s) * ramp)[None], 48e3, "V")
    if ramp_s or frequency_hz < 500:
        Limits(200.0).check_filtered(tone, None)


def test_corner_draws_more_current_than_straight_lines():
    """A step draws 4 G / pi times the current (G: Catalan's constant)."""
    step = Signal(np.r_[np.zeros(400), np.ones(400), np.linspace(1, 0, 400)][None], RATE_HZ, "V")
    load = replace(FINGER, leak_resistance_ohm=math.inf)
    catalan = 0.915965594177219
    ratio = load.filtered_current_a(step, 0.0) / load.current_peak_a(step)
    assert ratio == pytest.approx(4 * catalan / np.pi, rel=2e-3)


def test_weakened_signal_draws_current_of_its_changes():
    tone = Signal((np.sin(np.arange(4000) / 5) * np.hanning(4000))[None], RATE_HZ, "V")
    more_a = FINGER.filtered_current_a(tone, 0.0, rise_s=0.01) - FINGER.filtered_current_a(tone, 0.0)
    assert more_a == pytest.approx(FINGER.capacitance_f * 1.0 / 0.01, rel=0.01)
    assert FINGER.filtered_charge_c(tone, 0.0, rise_s=0.01) > FINGER.filtered_charge_c(tone, 0.0)


def test_displacement_counts_the_growth_of_each_channel():
    """One channel grows between its samples, the other does not."""
    samples = np.zeros((2, 200))
    samples[0] = 10 * np.sign(np.sinc(np.arange(200) - 99.5))
    samples[1] = 100 * np.hanning(200)
    exact_m = np.abs(dense(samples)[1]).max(axis=1) @ PATCHES.displacement_m_per_v
    found_m = PATCHES.filtered_displacement_m(Signal(samples, RATE_HZ, "V"), 0.0)
    assert found_m == pytest.approx(exact_m, rel=1e-3)


def test_unlimited_limits_hold_for_no_filter():
    bits = Signal(np.random.default_rng(0).choice([-1e300, 1e300], (1, 900)), RATE_HZ, "V")
    unlimited = Limits(UNLIMITED, UNLIMITED, UNLIMITED, UNLIMITED, UNLIMITED)
    unlimited.check_filtered(bits, Load("piezo", 1e-9, displacement_m_per_v=(1e-7,)))


@pytest.mark.parametrize("n_samples", [0, 1])
def test_limits_accept_at_most_one_sample(n_samples):
    signal = Signal(np.full((2, n_samples), 100.0), RATE_HZ, "V")
    replace(LIMITS, voltage_peak_v=100.0, displacement_peak_m=1.0).check_filtered(signal, PATCHES)


MISSED_OF_QUARTER_RATE = 1 - math.cos(math.pi / 4 / N_PHASES)
GRID = 1 / math.cos(math.pi / 2 / N_PHASES)
"""The largest ratio of a peak to its value on the grid of the code."""
course_samples = arrays(np.float64, st.integers(1, 60), elements=st.floats(-100, 100, allow_subnormal=False))
weight = st.floats(0, 2)


def worst(n):
    """Return n samples of magnitude 1 with the largest possible peak."""
    return np.sign(np.sinc(np.arange(n) - n // 2 + 0.5))


@given(course_samples, weight, weight)
def test_course_peak_is_that_of_a_dense_sum(samples, value, slope):
    _, course, change = dense(samples)
    exact = np.abs(value * course + slope * change).max()
    size = max(value, slope) * np.abs(samples).max()
    found = course_peak(samples, 0.0, value=value, slope=slope)
    # either grid may be nearer to the peak
    assert exact / GRID - ROUNDING * size <= found <= exact * GRID + ROUNDING * size


@given(course_samples, weight, weight, st.floats(0.01, 3.0))
def test_course_peak_finds_every_peak_above_the_bound(samples, value, slope, part):
    size = max(value, slope) * np.abs(samples).max()
    largest = course_peak(samples, 0.0, value=value, slope=slope)
    bound = part * largest
    found = course_peak(samples, bound, value=value, slope=slope)
    assert found == pytest.approx(largest, rel=1e-6) if largest > bound * GRID + ROUNDING * size else found <= largest
    assert found <= bound or found == pytest.approx(largest, rel=GRID - 1, abs=ROUNDING * size)


@given(course_samples, arrays(np.float64, 60, elements=st.floats(-100, 100)))
def test_course_peak_adds_straight_lines(samples, lines):
    added = lines[: len(samples)]
    at, course, _ = dense(samples)
    exact = np.abs(course + np.interp(at, np.arange(-1, len(samples)), np.append(0.0, added))).max()
    size = max(np.abs(samples).max(), np.abs(added).max())
    # the dense points contain each corner of the lines; between points both may miss part of a peak
    assert course_peak(samples, 0.0, added=added) == pytest.approx(exact, rel=0.01, abs=0.01 * size)


@pytest.mark.parametrize("phase_rad", [0.0, 0.3, math.pi / 4, 0.785])
def test_quarter_rate_sine_has_its_amplitude(phase_rad):
    """Samples reach cos(phase) or sin(phase), the course reaches 1."""
    samples = np.sin(np.pi / 2 * np.arange(20_000) + phase_rad) * np.hanning(20_000)
    assert course_peak(samples, 0.0) == pytest.approx(1.0, abs=MISSED_OF_QUARTER_RATE)


def test_peak_of_worst_samples_grows_with_number():
    """The sum is 2/pi (ln(n / 2) + ln 4 + Euler's constant)."""
    for n in (2, 20, 200, 500):
        exact = np.abs(np.sinc(np.arange(n) - n // 2 + 0.5)).sum()
        assert course_peak(worst(n), 0.0) == pytest.approx(exact, rel=1e-6)
    assert exact == pytest.approx(2 / np.pi * (math.log(1000) + np.euler_gamma), rel=1e-3)


def test_course_peak_is_found_in_any_block():
    """Some peaks are between two blocks."""
    for at in (0, 1, 3070, 3071, 3072, 4095, 9999):
        samples = np.zeros(10_001)
        samples[at : at + 2] = 1.0
        assert course_peak(samples, 1.1) == pytest.approx(2 * np.sinc(0.5), rel=1e-6)


def test_course_peak_finds_a_short_part():
    samples = np.zeros(1_000_000)
    samples[-500:] = worst(500)
    assert course_peak(samples, 1.0) == pytest.approx(course_peak(worst(500), 1.0), rel=1e-6)


@pytest.mark.parametrize("samples", [[], [0.0], [0.0] * 5000])
def test_course_peak_of_silence_is_zero(samples):
    assert course_peak(np.array(samples), 0.0, added=np.array(samples)) == 0.0


@pytest.mark.parametrize("scale", [1e-300, 1e-30, 1.0, 1e30, 1e300])
def test_course_peak_scales_with_its_samples(scale):
    samples = worst(40)
    assert course_peak(scale * samples, 0.0) / scale == pytest.approx(course_peak(samples, 0.0), rel=1e-12)


def test_course_peak_above_the_largest_number_is_infinite():
    assert course_peak(1e308 * worst(100), 1e308) == math.inf
    assert course_peak(np.array([1e308]), 1e308, value=100.0) == math.inf


def test_smooth_samples_need_no_transform(monkeypatch):
    monkeypatch.setattr(reconstruction, "_peak", None)
    tone = np.sin(2 * np.pi * np.arange(9600) / 480) * np.hanning(9600)
    assert course_peak(tone, 1.001) <= 1.001
    assert course_peak(worst(500), 5.1) <= 5.1
