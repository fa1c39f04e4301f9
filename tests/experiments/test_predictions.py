"""Predictions of findings 1 and 2: flights of the pulp, felt energy, draws and their bands."""

import math

import numpy as np
import pytest

from tactometry.experiments.thesis.predicted_threshold import felt, flights
from tactometry.experiments.thesis.reproduction import band_of
from tactometry.experiments.thesis.spread import RANGES, draws
from tactometry.stimuli.perception.channels import P, channel_thresholds_db


def test_flight_without_resistance_is_a_parabola():
    speeds = np.array([0.01, 1.0])
    times_s, heights_m = flights(4e-4, 1e-6, 2.0, speeds)
    np.testing.assert_allclose(times_s[:, -1], 2 * 4e-4 * speeds / 2.0, rtol=1e-5)
    np.testing.assert_allclose(heights_m.max(axis=1), 4e-4 * speeds**2 / (2 * 2.0), rtol=1e-4)


def test_flight_ends_where_it_began_and_is_shorter_with_resistance():
    (free_s, _), (damped_s, heights_m) = (flights(4e-4, resistance, 1.0, np.array([0.5])) for resistance in (0.1, 5.0))
    assert damped_s[0, -1] < free_s[0, -1]
    assert abs(heights_m[0, -1]) < 1e-9 * heights_m.max()


def test_short_pulse_is_felt_by_its_area():
    """A pulse of area a has the energy 2 a^2 times the integral of the squared sensitivity."""
    times_s = np.linspace(0.0, 1e-5, 101)
    frequency_hz = np.linspace(35.0, 800.0, 20_001)
    squared = 10 ** (-channel_thresholds_db(frequency_hz)[P] / 10)
    expected = 1e-8 * math.sqrt(2 * np.trapezoid(squared, frequency_hz))
    pulse = np.where(np.abs(times_s - 5e-6) < 4e-6, 1.0, 0.0)
    pulse *= 1e-8 / (pulse.sum() * 1e-7)
    assert felt(times_s, pulse) == pytest.approx(expected, rel=1e-2)


def test_draws_are_seeded_and_within_their_ranges():
    ranges = {one.label: one for one in RANGES}
    first, again = list(draws(50)), list(draws(50))
    assert first == again
    for name, values in {
        "shear viscosity, Pa s": [one.tissue.shear_viscosity_pa_s for one in first],
        "density, kg/m3": [one.tissue.density_kg_per_m3 for one in first],
        "time of summation, s": [one.summation_s for one in first],
        "threshold at 250 Hz, um": [1e6 * one.threshold_m for one in first],
    }.items():
        assert ranges[name].low <= min(values) < max(values) <= ranges[name].high


def test_band_holds_what_lies_between_its_percentiles():
    band = band_of(np.arange(101.0))
    assert (band.low, band.value, band.high) == (5.0, 50.0, 95.0)
    assert band.holds(6.0)
    assert not band.holds(4.0)
