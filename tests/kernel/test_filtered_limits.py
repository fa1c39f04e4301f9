"""Limits after a reconstruction filter, against a dense sum of sincs."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st
from hypothesis.extra.numpy import arrays

from tactometry.arguments.unlimited import UNLIMITED
from tactometry.errors import LimitExceeded
from tactometry.safety.limits import Limits
from tactometry.safety.load import Load
from tactometry.safety.reconstruction import TOLERANCE
from tactometry.signal import Signal

RATE_HZ, N_POINTS, N_AROUND = 1000.0, 32, 30
FINGER = Load("electrode", capacitance_f=2e-9, leak_resistance_ohm=5e6)
PATCHES = Load("piezo", capacitance_f=1e-8, displacement_m_per_v=(1e-7, 3e-7))
LIMITS = Limits(1e6, current_peak_a=1e6, charge_peak_c=1e6, duration_s=60.0, duty=1.0, session_s=1e6)
MISSED = 2.5e-3
"""Relative: the tolerance of the limits, and what lies between the points of both computations."""

volts = arrays(np.float64, st.tuples(st.just(2), st.integers(1, 30)), elements=st.floats(-100, 100))
part = st.floats(0.2, 2.0)


def dense(samples):
    """Return the filtered voltage (V) and its derivative (V/s)."""
    n = samples.shape[1]
    lags = np.arange(-N_AROUND * N_POINTS, (n + N_AROUND) * N_POINTS)[:, None] / N_POINTS - np.arange(n)
    change = np.divide(np.cos(np.pi * lags) - np.sinc(lags), lags, out=np.zeros_like(lags), where=lags != 0)
    return samples @ np.sinc(lags).T, samples @ change.T * RATE_HZ


def peaks(samples):
    """Compute the peak of each limited quantity independently."""
    course, slope = dense(samples)
    leaked = Load("electrode", 2e-9, leak_resistance_ohm=5e6)
    at = np.arange(-N_AROUND * N_POINTS, (samples.shape[1] + N_AROUND) * N_POINTS) / N_POINTS
    around = np.pad(samples, ((0, 0), (1, 1)))
    passed = np.cumsum((around[:, 1:] + around[:, :-1]) / 2, axis=1) / RATE_HZ / leaked.leak_resistance_ohm
    lines = np.array([np.interp(at, np.arange(-1, samples.shape[1] + 1), np.append(0.0, each)) for each in passed])
    return {
        "voltage_peak_v": np.abs(course).max(),
        "current_peak_a": np.abs(FINGER.capacitance_f * slope + course / FINGER.leak_resistance_ohm).max(),
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
    exact_m = np.abs(dense(samples)[0]).max(axis=1) @ PATCHES.displacement_m_per_v
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
