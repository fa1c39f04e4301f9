"""Every number of the physics checks (parameter set P0, 100 V, 1 cm2), to its stated digits."""

import numpy as np
import pytest
from corneum_closed_form import (
    rise_peak_v,
    sine_mean_force_n,
    square_edge_v,
    square_harmonic_force_n,
    square_mean_force_n,
    step_impulse_n_s,
    step_voltage_v,
)

from tactometry.stimuli.electrovibration import Sine, Skin, Square, Step, electrostatic_force_n
from tactometry.stimuli.electrovibration.attraction.force import force_per_square_volt_n
from tactometry.stimuli.electrovibration.skin.relaxation import Solution

P0 = Skin()
AREA_M2 = 1e-4
V0 = 100.0
B = force_per_square_volt_n(P0, AREA_M2)


def law_n(law: str, **changes: float) -> float:
    skin = Skin(**{"corneum_resistivity_ohm_m": np.inf, **changes})
    return float(electrostatic_force_n([V0], rate_hz=1.0, skin=skin, area_m2=AREA_M2, law=law)[0])


def test_derived_values() -> None:
    assert P0.insulator_capacitance_f(AREA_M2) == pytest.approx(3.4531332e-9, rel=1e-8)
    assert P0.corneum_capacitance_f(AREA_M2) == pytest.approx(4.4270939e-9, rel=1e-8)
    assert P0.corneum_resistance_ohm(AREA_M2) == pytest.approx(40e3, rel=1e-14)
    assert P0.k == pytest.approx(0.438202247, abs=5e-10)
    assert P0.tau_s == pytest.approx(315.209086e-6, abs=5e-13)
    assert P0.cutoff_hz == pytest.approx(504.918640, abs=5e-7)
    assert pytest.approx(1.10677348e-5, abs=5e-14) == B


FREQUENCIES_HZ = [15, 30, 60, 120, 240, 480, 1920]
MEANS_MN = [0.0093699, 0.0373807, 0.1479612, 0.5681134, 1.9583526, 5.0444265, 9.9388513]


def test_gain() -> None:
    expected = [0.013012, 0.025990, 0.051708, 0.101322, 0.188118, 0.301920, 0.423793]
    np.testing.assert_allclose(P0.gain(FREQUENCIES_HZ), expected, rtol=0, atol=5.1e-7)


def test_mean_force_of_a_sine() -> None:
    mean_mn = 1e3 * sine_mean_force_n(FREQUENCIES_HZ, V0, P0, AREA_M2)
    np.testing.assert_allclose(mean_mn, MEANS_MN, rtol=0, atol=5.1e-8)


def test_step() -> None:
    assert 1e3 * B * step_voltage_v(0.0, V0, P0) ** 2 == pytest.approx(21.2523982, abs=5e-8)
    assert 1e6 * step_impulse_n_s(V0, P0, AREA_M2) == pytest.approx(3.34947450, abs=5e-9)


@pytest.mark.parametrize(
    ("rise_s", "peak_v", "force_mn"),
    [
        (10e-6, 43.132420, 20.590476),
        (100e-6, 37.549525, 15.605139),
        (1e-3, 13.233804, 1.938332),
        (10e-3, 1.381253, 0.0211157),
    ],
)
def test_rise(rise_s: float, peak_v: float, force_mn: float) -> None:
    found_v = float(rise_peak_v(rise_s, V0, P0))
    assert found_v == pytest.approx(peak_v, abs=5e-7)
    assert float(exact_v(Step(rise_s=rise_s, duration_s=0.1), rise_s)) == pytest.approx(peak_v, abs=5e-7)
    assert 1e3 * B * found_v**2 == pytest.approx(force_mn, abs=5e-7 if force_mn > 1 else 5e-8)


@pytest.mark.parametrize(
    ("frequency_hz", "edge_v", "peak_mn", "mean_mn"),
    [(60.0, 87.640449, 85.009593, 1.6077477), (1920.0, 60.957854, 41.126152, 20.1207436)],
)
def test_square(frequency_hz: float, edge_v: float, peak_mn: float, mean_mn: float) -> None:
    found_v = float(square_edge_v(frequency_hz, V0, P0))
    assert found_v == pytest.approx(edge_v, abs=5e-7)
    assert 1e3 * B * found_v**2 == pytest.approx(peak_mn, abs=5e-7)
    assert 1e3 * square_mean_force_n(frequency_hz, V0, P0, AREA_M2) == pytest.approx(mean_mn, abs=1e-7)
    square = Square(frequency_hz, ramp_s=0.0)
    late_s = square.pieces(40.0).starts_s[int(0.5 * 2 * frequency_hz) :][:2]
    np.testing.assert_allclose(np.abs(exact_v(square, late_s)), edge_v, rtol=0, atol=5e-7)


def test_harmonics_of_the_force_of_a_square() -> None:
    found_mn = 1e3 * square_harmonic_force_n([1, 2, 3], 60.0, V0, P0, AREA_M2)
    np.testing.assert_allclose(found_mn, [3.19303, 3.12836, 3.02879], rtol=0, atol=5e-6)


def exact_v(stimulus, t_s) -> np.ndarray:
    return Solution(stimulus.pieces(40.0), P0.relaxations(AREA_M2)).at(t_s)


@pytest.mark.parametrize(("frequency_hz", "mean_mn"), list(zip(FREQUENCIES_HZ, MEANS_MN, strict=True)))
def test_exact_sine_force_is_mean_plus_second_harmonic(frequency_hz: float, mean_mn: float) -> None:
    late_s = 0.5 + np.arange(64) / 64 / frequency_hz
    lines_mn = np.fft.rfft(1e3 * B * exact_v(Sine(frequency_hz, ramp_s=0.0), late_s) ** 2) / 64
    assert lines_mn[0].real == pytest.approx(mean_mn, abs=5.1e-8)
    assert 2 * abs(lines_mn[2]) == pytest.approx(lines_mn[0].real, rel=1e-12)
    np.testing.assert_allclose(np.delete(lines_mn, [0, 2]), 0, atol=1e-12 * mean_mn)


def test_four_laws_on_one_voltage() -> None:
    assert law_n("sc_layer") == pytest.approx(21.2524e-3, abs=5e-8)
    assert law_n("interface") == pytest.approx(21.2524, abs=5e-5)
    assert law_n("total_thickness") == pytest.approx(48.25777e-3, abs=5e-9)


@pytest.mark.parametrize(
    ("gap_m", "force_n"), [(1e-6, 2.087139), (2e-6, 0.733697), (5e-6, 0.148698), (10e-6, 0.0404905)]
)
def test_interface_law_with_a_gap(gap_m: float, force_n: float) -> None:
    assert law_n("interface", gap_m=gap_m) == pytest.approx(force_n, abs=5e-7 if force_n > 0.1 else 5e-8)


def test_identities_between_the_laws_are_exact() -> None:
    s_m = P0.insulator_equivalent_m + P0.corneum_equivalent_m
    d_m = P0.insulator_thickness_m + P0.corneum_thickness_m
    assert law_n("interface") / law_n("sc_layer") == pytest.approx(P0.corneum_permittivity, rel=1e-14)
    assert law_n("total_thickness") / law_n("interface") == pytest.approx(s_m / d_m, rel=1e-14)
