"""The plate in closed form: frequencies, dispersion, mode counts, statics, impedance."""

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st

from tactometry.stimuli.time_reversal import Plate
from tactometry.stimuli.time_reversal.plate.dispersion import (
    group_velocity_m_per_s,
    mindlin_angular_frequency_rad_per_s,
    mindlin_wavenumber_rad_per_m,
    phase_velocity_m_per_s,
    wavelength_m,
    wavenumber_rad_per_m,
)
from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN, BOROFLOAT_33
from tactometry.stimuli.time_reversal.plate.modes import modes_of
from tactometry.stimuli.time_reversal.plate.statics import bending_stress_pa, deflection_m

CENTRE = (0.1485, 0.105)


def square(thickness_m: float = 0.01, boundary: str = "SSSS", poisson_ratio: float = 0.3) -> Plate:
    return Plate(1.0, 1.0, thickness_m, 70e9, poisson_ratio, 2500.0, boundary)


def frequency_parameters(plate: Plate, largest: float) -> np.ndarray:
    unit = plate.wave_constant_m2_per_s / plate.length_m**2
    return 2 * np.pi * plate.frequencies_hz(largest * unit / (2 * np.pi)) / unit


def test_a4_simply_supported_frequencies_are_the_exact_ones():
    expected = [29.6108, 59.2196, 88.8345, 108.5677, 118.4433, 167.7913]
    assert frequency_parameters(A4_SCREEN, 170.0) == pytest.approx(expected, abs=5e-5)


def test_square_plate_has_degenerate_modes():
    found = frequency_parameters(square(), 130.0)
    expected = [math.pi**2 * s for s in (2, 5, 5, 8, 10, 10, 13, 13)]
    assert found == pytest.approx(expected, rel=1e-14)


def test_413_modes_between_1_and_25_khz():
    f = A4_SCREEN.frequencies_hz(25e3)
    assert np.sum(f >= 1e3) == 413


def test_modal_density_in_milliseconds():
    for thickness, expected in ((0.5e-3, 39.5), (1.1e-3, 17.96), (2e-3, 9.88), (3e-3, 6.59)):
        plate = BOROFLOAT_33.plate(0.297, 0.210, thickness, "SSSS")
        assert plate.modal_density_s * 1e3 == pytest.approx(expected, rel=2e-3)


def test_modal_density_is_the_slope_of_the_exact_count():
    count = [len(A4_SCREEN.frequencies_hz(f)) for f in (100e3, 400e3)]
    perimeter = A4_SCREEN.perimeter_m / (4 * math.pi) * np.diff(wavenumber_rad_per_m(A4_SCREEN, [100e3, 400e3]))[0]
    assert (count[1] - count[0] + perimeter) / 300e3 == pytest.approx(A4_SCREEN.modal_density_s, rel=2e-3)


def test_point_impedance():
    for thickness, expected in ((0.5e-3, 7.0), (1.1e-3, 34.1), (2e-3, 113.0), (3e-3, 253.0)):
        plate = BOROFLOAT_33.plate(0.297, 0.210, thickness, "SSSS")
        assert plate.point_impedance_n_s_per_m == pytest.approx(expected, rel=6e-3)


@pytest.mark.parametrize(
    ("ratio", "shear_factor", "expected"),
    [(0.1, 5 / 6, 19.0651), (0.2, 5 / 6, 17.4485), (0.1, 0.86667, 19.0840), (0.2, 0.86667, 17.5055)],
)
def test_mindlin_square_plate_of_liew_and_of_hosseini_hashemi(ratio, shear_factor, expected):
    plate = square(ratio)
    omega = mindlin_angular_frequency_rad_per_s(plate, math.sqrt(2) * math.pi, shear_factor)
    found = omega / plate.wave_constant_m2_per_s
    printed = 5e-5 * math.pi**2 if shear_factor == 5 / 6 else 6e-5
    assert found == pytest.approx(expected, abs=printed), "Liew prints lambda / pi^2 with four decimals"


def test_mindlin_modes_of_the_screen_are_those_of_its_dispersion():
    modes = modes_of(A4_SCREEN, 60e3, shear_factor=5 / 6)
    k2 = (np.pi * modes.m / 0.297) ** 2 + (np.pi * modes.n / 0.210) ** 2
    expected = mindlin_angular_frequency_rad_per_s(A4_SCREEN, np.sqrt(k2))
    assert modes.angular_frequency_rad_per_s == pytest.approx(expected, rel=1e-13)
    assert modes.frequency_hz[-1] <= 60e3 * (1 + 1e-12)


@given(st.floats(1.0, 1e7), st.floats(1e-4, 1e-2))
def test_mindlin_wavenumber_and_frequency_are_inverse(frequency_hz, thickness_m):
    plate = BOROFLOAT_33.plate(0.3, 0.2, thickness_m, "SSSS")
    k = mindlin_wavenumber_rad_per_m(plate, frequency_hz)
    back = mindlin_angular_frequency_rad_per_s(plate, k) / (2 * np.pi)
    assert back == pytest.approx(frequency_hz, rel=1e-9)


def test_thin_plate_error_of_the_wavelength():
    f = np.array([12.5e3, 25e3, 60e3, 100e3])
    thick = 2 * np.pi / mindlin_wavenumber_rad_per_m(A4_SCREEN, f)
    error = 1 - thick / wavelength_m(A4_SCREEN, f)
    assert error * 100 == pytest.approx([0.45, 0.90, 2.1, 3.5], rel=0.03)


def test_kirchhoff_wavelengths_and_velocities():
    f = np.array([1e3, 5e3, 12.5e3, 25e3, 40e3, 60e3, 100e3])
    expected = [104.5, 46.7, 29.5, 20.9, 16.5, 13.5, 10.4]
    assert wavelength_m(A4_SCREEN, f) * 1e3 == pytest.approx(expected, abs=0.06)
    assert phase_velocity_m_per_s(A4_SCREEN, 25e3) == pytest.approx(522, abs=0.6)
    assert group_velocity_m_per_s(A4_SCREEN, 25e3) == pytest.approx(1045, abs=1)
    assert A4_SCREEN.wave_constant_m2_per_s == pytest.approx(1.7362, abs=6e-5)


def test_central_deflection_of_the_simply_supported_plate_is_timoshenkos():
    for thickness, expected_um in ((0.5e-3, 1900), (1.1e-3, 178), (2e-3, 29.6), (3e-3, 8.8)):
        plate = BOROFLOAT_33.plate(0.297, 0.210, thickness, "SSSS")
        w = deflection_m(plate, 2.0, CENTRE, *CENTRE)[0]
        assert w == pytest.approx(0.014940 * 2 * 0.21**2 / plate.bending_rigidity_n_m, rel=1e-5)
        assert w * 1e6 == pytest.approx(expected_um, rel=6e-3)


def test_deflection_of_the_square_is_0_0116():
    plate = square()
    w = deflection_m(plate, 1.0, (0.5, 0.5), 0.5, 0.5)[0] * plate.bending_rigidity_n_m
    assert w == pytest.approx(0.01160, abs=5e-6)


def test_deflection_is_reciprocal_and_zero_on_the_edge():
    there = deflection_m(A4_SCREEN, 1.0, (0.05, 0.06), 0.2, 0.15)[0]
    back = deflection_m(A4_SCREEN, 1.0, (0.2, 0.15), 0.05, 0.06)[0]
    assert there == pytest.approx(back, rel=1e-9)
    assert np.abs(deflection_m(A4_SCREEN, 1.0, (0.1, 0.1), [0.0, 0.1], [0.1, 0.21])) == pytest.approx(0, abs=1e-18)


def test_deflection_of_the_clamped_square_is_0_0056():
    plate = square(boundary="CCCC")
    w = deflection_m(plate, 1.0, (0.5, 0.5), 0.5, 0.5)[0] * plate.bending_rigidity_n_m
    assert w == pytest.approx(0.00560, abs=2e-5)


def test_bending_stress_falls_with_the_square_of_thickness():
    thin, thick = (bending_stress_pa(BOROFLOAT_33.plate(0.297, 0.21, h, "SSSS"), 2.0, 10e-3) for h in (1e-3, 2e-3))
    assert thin / thick == pytest.approx(4.0, rel=1e-9)


def test_bending_stress_under_a_uniform_load_is_timoshenkos_0_0479():
    plate = square(poisson_ratio=0.3)
    moment = bending_stress_pa(plate, 1.0, 1.0) * plate.thickness_m**2 / 6
    assert moment == pytest.approx(0.0479, abs=5e-5)


def test_no_mode_below_the_first_is_an_empty_list():
    assert A4_SCREEN.frequencies_hz(50.0).size == 0


def test_thick_glass_waves_approach_thin_and_shear_limits():
    shear = math.sqrt(5 / 6 * 64e9 / 2.4 / 2230)
    phase = 2 * math.pi * 1e9 / mindlin_wavenumber_rad_per_m(A4_SCREEN, 1e9)
    assert float(phase) == pytest.approx(shear, rel=1e-5)
    thin = wavenumber_rad_per_m(A4_SCREEN, 1.0)
    assert mindlin_wavenumber_rad_per_m(A4_SCREEN, 1.0) == pytest.approx(thin, rel=1e-5)
