"""The exact recurrence for sampled voltages, against closed forms and an independent solver."""

import numpy as np
import pytest
from corneum_closed_form import (
    corneum_voltage_v,
    sine_mean_force_n,
    sine_voltage_v,
    square_edge_v,
    square_harmonic_force_n,
    square_mean_force_n,
    step_voltage_v,
)
from hypothesis import given, strategies as st
from scipy.integrate import solve_ivp

from tactometry.stimuli.electrovibration import Skin, electrostatic_force_n
from tactometry.stimuli.electrovibration.attraction.force import force_per_square_volt_n

P0 = Skin()
AREA_M2 = 1e-4
positive = st.floats(1e-12, 1e12)


def sc_force_n(voltage_v: np.ndarray, rate_hz: float, skin: Skin = P0, area_m2: float = AREA_M2) -> np.ndarray:
    return electrostatic_force_n(voltage_v, rate_hz=rate_hz, skin=skin, area_m2=area_m2, law="sc_layer")


def test_step_is_exact_at_any_rate() -> None:
    for rate_hz in (1e2, 1e4, 1e6):
        t_s = np.arange(100) / rate_hz
        found_v = corneum_voltage_v(np.full(100, 100.0), rate_hz, P0, AREA_M2)
        np.testing.assert_allclose(found_v, step_voltage_v(t_s, 100.0, P0), rtol=1e-13, atol=1e-300)


@pytest.mark.parametrize("rise_s", [10e-6, 1e-3])
def test_voltage_ramp_is_independent_of_its_sampling(rise_s: float) -> None:
    coarse_v = corneum_voltage_v(np.array([0.0, 100.0]), 1 / rise_s, P0, AREA_M2)[-1]
    fine_v = corneum_voltage_v(np.linspace(0, 100, 10_001), 10_000 / rise_s, P0, AREA_M2)[-1]
    assert fine_v == pytest.approx(coarse_v, rel=1e-12)


def test_long_records_agree_with_short_ones_across_the_blocks() -> None:
    rng = np.random.default_rng(0)
    voltage_v = rng.normal(size=10_000)
    steps_v = np.diff(voltage_v, prepend=0.0)
    decay = 1 / (P0.tau_s * 1e6)
    expected_v, state = np.empty(voltage_v.size), 0.0
    for n, step_v in enumerate(steps_v):
        state = np.exp(-decay) * state + (step_v if n == 0 else step_v * -np.expm1(-decay) / decay)
        expected_v[n] = P0.k * state
    np.testing.assert_allclose(corneum_voltage_v(voltage_v, 1e6, P0, AREA_M2), expected_v, rtol=0, atol=1e-13)


def test_stacked_voltages_are_solved_separately() -> None:
    voltages_v = np.random.default_rng(1).normal(size=(2, 3, 5_000))
    stacked_n = sc_force_n(voltages_v, 1e5)
    assert stacked_n.shape == voltages_v.shape
    np.testing.assert_array_equal(stacked_n[1, 2], sc_force_n(voltages_v[1, 2], 1e5))


def test_sampled_sine_error_falls_with_step_squared() -> None:
    errors_v = []
    for rate_hz in (1e5, 1e6):
        t_s = np.arange(int(0.02 * rate_hz)) / rate_hz
        sampled_v = corneum_voltage_v(np.sin(2 * np.pi * 240 * t_s), rate_hz, P0, AREA_M2)
        errors_v.append(np.abs(sampled_v - sine_voltage_v(t_s, 240.0, 1.0, P0)).max())
    assert errors_v[1] < 1e-7
    assert errors_v[0] / errors_v[1] == pytest.approx(100, rel=0.05)


def test_sine_force_is_mean_plus_double_frequency() -> None:
    rate_hz, frequency_hz = 1e6, 250.0
    t_s = np.arange(40_000) / rate_hz
    force_n = sc_force_n(100 * np.sin(2 * np.pi * frequency_hz * t_s), rate_hz)[-20_000:]
    mean_n = float(sine_mean_force_n(frequency_hz, 100.0, P0, AREA_M2))
    amplitudes_n = np.abs(np.fft.rfft(force_n)) / force_n.size * np.r_[1, np.full(10_000, 2)]
    bins = (np.array([0, 1, 2, 3]) * frequency_hz * force_n.size / rate_hz).astype(int)
    np.testing.assert_allclose(amplitudes_n[bins], [mean_n, 0, mean_n, 0], rtol=1e-5, atol=1e-5 * mean_n)
    assert force_n.max() == pytest.approx(2 * mean_n, rel=1e-5)


def test_square_in_steady_state() -> None:
    rate_hz, frequency_hz = 1.2e6, 60.0
    n_half = int(rate_hz / frequency_hz / 2)
    voltage_v = 100 * np.tile(np.r_[np.ones(n_half), -np.ones(n_half)], 3)
    force_n = sc_force_n(voltage_v, rate_hz)[-2 * n_half :]
    # A jump of the samples is a ramp of one sample h: its end lies h/(2 tau) below the edge of a true square.
    assert force_n.max() == pytest.approx(
        force_per_square_volt_n(P0, AREA_M2) * float(square_edge_v(frequency_hz, 100.0, P0)) ** 2, rel=3e-3
    )
    assert force_n.mean() == pytest.approx(float(square_mean_force_n(60.0, 100.0, P0, AREA_M2)), rel=3e-3)
    amplitudes_n = 2 * np.abs(np.fft.rfft(force_n)) / force_n.size
    expected_n = square_harmonic_force_n([1, 2, 3], frequency_hz, 100.0, P0, AREA_M2)
    np.testing.assert_allclose(amplitudes_n[[2, 4, 6]], expected_n, rtol=3e-3)


def test_constant_offset_force_decays_in_ten_time_constants() -> None:
    rate_hz = 1e5
    t_s = np.arange(20_000) / rate_hz
    late = t_s > 40 * P0.tau_s
    tone_v = 100 * np.sin(2 * np.pi * 60 * t_s)
    np.testing.assert_allclose(
        sc_force_n(tone_v + 50, rate_hz)[late], sc_force_n(tone_v, rate_hz)[late], rtol=0, atol=1e-15
    )


@given(area_m2=st.floats(1e-9, 1.0), factor=st.floats(0.1, 10))
def test_force_is_proportional_to_area_without_body_resistance(area_m2: float, factor: float) -> None:
    voltage_v = np.random.default_rng(2).normal(size=50)
    one, other = (sc_force_n(voltage_v, 1e4, area_m2=a) / a for a in (area_m2, area_m2 * factor))
    np.testing.assert_allclose(one, other, rtol=1e-13)


def test_force_over_area_depends_on_area_with_body_resistance() -> None:
    skin = Skin(body_resistance_ohm=1e3)
    step_v = np.full(20, 100.0)
    one, other = (sc_force_n(step_v, 1e6, skin, a)[1:] / a for a in (1e-4, 2e-4))
    assert np.abs(one / other - 1).max() > 0.1


def test_body_resistance_matches_numerical_circuit_solution() -> None:
    skin = Skin(body_resistance_ohm=1e4)
    c_i, c_sc = skin.insulator_capacitance_f(AREA_M2), skin.corneum_capacitance_f(AREA_M2)
    r_sc, r_b = skin.corneum_resistance_ohm(AREA_M2), skin.body_resistance_ohm

    def slope(_: float, v: np.ndarray) -> list[float]:
        current_a = (100 - v[0] - v[1]) / r_b
        return [current_a / c_i, (current_a - v[1] / r_sc) / c_sc]

    t_s = np.arange(500) / 1e6
    solved = solve_ivp(slope, (0, t_s[-1]), [0, 0], t_eval=t_s, method="DOP853", rtol=1e-12, atol=1e-12)
    found_v = corneum_voltage_v(np.full(500, 100.0), 1e6, skin, AREA_M2)
    np.testing.assert_allclose(found_v, solved.y[1], rtol=0, atol=1e-8)


@pytest.mark.parametrize("body_ohm", [1e-6, 1e-3])
def test_a_small_body_resistance_tends_to_none(body_ohm: float) -> None:
    frequencies_hz = [0.0, 1.0, 60.0, 1e4]
    np.testing.assert_allclose(
        Skin(body_resistance_ohm=body_ohm).response(frequencies_hz), P0.response(frequencies_hz), atol=1e-6
    )


def test_square_wave_force_is_constant_on_lossless_skin() -> None:
    square_v = np.tile(np.r_[np.ones(10), -np.ones(10)], 20) * 100
    force_n = sc_force_n(square_v, 1e4, Skin(corneum_resistivity_ohm_m=np.inf))
    np.testing.assert_allclose(force_n, 21.2523982e-3, rtol=1e-8)


@given(rho=st.one_of(st.sampled_from([0.0, np.inf]), positive), body_ohm=st.sampled_from([0.0, 1e-9, 1e3, 1e9]))
def test_force_is_finite_and_nonnegative_at_any_resistivity(rho: float, body_ohm: float) -> None:
    skin = Skin(corneum_resistivity_ohm_m=rho, body_resistance_ohm=body_ohm)
    force_n = sc_force_n(np.array([100.0, -100.0, 0.0, 3.0]), 1e4, skin)
    assert np.isfinite(force_n).all()
    assert (force_n >= 0).all()
