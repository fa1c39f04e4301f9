"""Peaks between samples, against an independent dense sum of sincs."""

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st
from hypothesis.extra.numpy import arrays

from tactometry.safety import reconstruction
from tactometry.safety.reconstruction import N_PHASES, ROUNDING, course_peak

N_POINTS, N_AROUND = 48, 40
"""Points per sample of the dense sum, and samples before and after the signal."""
MISSED_OF_QUARTER_RATE = 1 - math.cos(math.pi / 4 / N_PHASES)
MISSED = 1 / math.cos(math.pi / 2 / N_PHASES)
volts = arrays(np.float64, st.integers(1, 60), elements=st.floats(-100, 100, allow_subnormal=False))
weight = st.floats(0, 2)


def dense(samples):
    """Compute the filtered course and its change per sample: both (n_points,)."""
    at = np.arange(-N_AROUND * N_POINTS, (len(samples) + N_AROUND) * N_POINTS) / N_POINTS
    lags = at[:, None] - np.arange(len(samples))
    sinc = np.sinc(lags)
    change = np.divide(np.cos(np.pi * lags) - sinc, lags, out=np.zeros_like(lags), where=lags != 0)
    return at, sinc @ samples, change @ samples


def worst(n):
    """Return n samples of magnitude 1 with the largest possible peak."""
    return np.sign(np.sinc(np.arange(n) - n // 2 + 0.5))


@given(volts, weight, weight)
def test_course_peak_is_that_of_a_dense_sum(samples, value, slope):
    _, course, change = dense(samples)
    exact = np.abs(value * course + slope * change).max()
    size = max(value, slope) * np.abs(samples).max()
    found = course_peak(samples, 0.0, value=value, slope=slope)
    # either grid may be nearer to the peak
    assert exact / MISSED - ROUNDING * size <= found <= exact * MISSED + ROUNDING * size


@given(volts, weight, weight, st.floats(0.01, 3.0))
def test_course_peak_finds_every_peak_above_the_bound(samples, value, slope, part):
    size = max(value, slope) * np.abs(samples).max()
    largest = course_peak(samples, 0.0, value=value, slope=slope)
    bound = part * largest
    found = course_peak(samples, bound, value=value, slope=slope)
    assert found == pytest.approx(largest, rel=1e-6) if largest > bound * MISSED + ROUNDING * size else found <= largest
    assert found <= bound or found == pytest.approx(largest, rel=MISSED - 1, abs=ROUNDING * size)


@given(volts, arrays(np.float64, 60, elements=st.floats(-100, 100)))
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
