"""Pacinian summation over trains of short events."""

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.signal import lfilter

from tactometry.stimuli.perception.channels import P, channel_thresholds_db
from tactometry.stimuli.perception.temporal_summation import HORIZON_S, TAU_S, likeness, summed_amplitude

RATE_HZ = 4000
trains = st.lists(st.tuples(st.floats(1e-3, 1.5), st.floats(0.0, 1.0)), min_size=1, max_size=30).map(
    lambda steps: (np.cumsum([gap_s for gap_s, _ in steps]), np.array([peak for _, peak in steps]))
)


def felt_db(n, repetition_hz):
    return 20 * np.log10(summed_amplitude(np.arange(n) / repetition_hz, np.ones(n)))


def energy(times_s, peaks):
    """Return the largest energy in a leaky integrator after the filter."""
    n = 2 ** int(np.ceil(np.log2((times_s[-1] + 1.0) * RATE_HZ)))
    samples = np.zeros(n)
    np.add.at(samples, np.round((times_s + 0.4) * RATE_HZ).astype(int), peaks)
    frequency_hz = np.fft.rfftfreq(n, 1 / RATE_HZ)
    gain = np.zeros(frequency_hz.size)
    gain[1:] = 10 ** (-channel_thresholds_db(frequency_hz[1:])[P] / 20)
    answer = np.fft.irfft(np.fft.rfft(samples) * gain, n)
    return lfilter([1.0], [1.0, -np.exp(-1 / RATE_HZ / TAU_S)], answer**2).max()


def filtered_db(n, repetition_hz, beginnings):
    """Return the level of the strongest start of a train.

    Relative to its first event.
    """
    times_s, one = np.arange(n) / repetition_hz, energy(np.zeros(1), np.ones(1))
    return max(10 * np.log10(energy(times_s[:k], np.ones(k)) / one) for k in beginnings)


@pytest.mark.parametrize("repetition_hz", [1, 2, 5, 10, 40, 100, 200, 250, 400, 500, 800, 1000])
@pytest.mark.parametrize("n", [2, 5, 12])
def test_train_matches_filtered_and_integrated_samples(n, repetition_hz):
    expected_db = filtered_db(n, repetition_hz, range(1, n + 1))
    assert felt_db(n, repetition_hz) == pytest.approx(expected_db, abs=0.2)


@pytest.mark.parametrize("repetition_hz", [1, 10, 100, 250, 500, 1000])
def test_thousand_foci_match_their_samples(repetition_hz):
    expected_db = filtered_db(1000, repetition_hz, (1, 2, 3, 1000))
    assert felt_db(1000, repetition_hz) == pytest.approx(expected_db, abs=0.2)


@pytest.mark.parametrize("peak", [0.0, 5e-324, 1e-170, 1e200])
def test_the_faintest_and_the_strongest_event_keep_their_amplitude(peak):
    assert summed_amplitude(np.array([0.0, 10.0]), np.array([peak, 0.0])) == peak


@given(st.floats(0.02, 100.0))
def test_distant_event_adds_only_its_energy(apart_s):
    """Beyond the filter response, the energy of the first event decays."""
    left_db = 10 * np.log10(1 + np.exp(-apart_s / TAU_S))
    assert 20 * np.log10(summed_amplitude(np.array([0.0, apart_s]), np.ones(2))) == pytest.approx(left_db, abs=0.07)


@given(trains)
def test_a_train_is_never_weaker_than_its_beginning(train):
    times_s, peaks = train
    felt = [summed_amplitude(times_s[:n], peaks[:n]) for n in range(1, len(peaks) + 1)]
    assert (np.diff(felt) >= -1e-12).all()


@given(trains, st.floats(1e-9, 1e9))
def test_train_is_bounded_and_proportional(train, factor):
    times_s, peaks = train
    felt = summed_amplitude(times_s, peaks)
    assert peaks.max() <= felt <= peaks.sum() * (1 + 1e-12)
    assert summed_amplitude(times_s, factor * peaks) == pytest.approx(factor * felt, rel=1e-9, abs=1e-300)


@given(trains)
def test_distant_events_add_at_most_their_energy(train):
    times_s, peaks = train
    apart_s = times_s + HORIZON_S * np.arange(peaks.size)
    assert summed_amplitude(apart_s, peaks) <= math.hypot(*peaks) * (1 + 1e-12)


@given(trains, st.randoms(use_true_random=False))
def test_summation_is_independent_of_event_order(train, random):
    times_s, peaks = train
    order = random.sample(range(peaks.size), peaks.size)
    assert summed_amplitude(times_s[order], peaks[order]) == pytest.approx(summed_amplitude(times_s, peaks), rel=1e-12)


@pytest.mark.parametrize("repetition_hz", [50.0, 100.0, 250.0])
def test_train_gain_with_duration_follows_leaky_integrator(repetition_hz):
    """The leaky integrator: 10 log10 (1 - exp(-d/tau)) for a duration d."""
    durations_s = np.array([0.08, 0.16, 0.32, 1.28, 5.12])
    found_db = [felt_db(round(d * repetition_hz), repetition_hz) for d in durations_s]
    expected_db = 10 * np.log10(-np.expm1(-durations_s / TAU_S))
    assert np.diff(found_db) == pytest.approx(np.diff(expected_db), abs=0.25)
    assert found_db[-1] - found_db[-2] < 0.03


def test_response_autocorrelation_matches_its_spectrum():
    frequency_hz = np.arange(35.0, 800.0, 0.01) + 0.005
    power = 10 ** (-channel_thresholds_db(frequency_hz)[P] / 10)
    lags_s = np.array([0.0, 0.5e-3, 2e-3, 4e-3, 0.011, 0.1, 0.2, 0.4, 1.0])
    expected = [np.cos(2 * np.pi * lag_s * frequency_hz) @ power / power.sum() for lag_s in lags_s]
    assert likeness(lags_s) == pytest.approx(expected, abs=2e-3)
