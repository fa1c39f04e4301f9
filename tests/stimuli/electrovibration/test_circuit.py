"""Corneum voltage and force, against closed forms and `solve_ivp` at a tolerance of 1e-12."""

import numpy as np
import pytest
from corneum_closed_form import (
    corneum_voltage_v,
    rise_peak_v,
    sine_mean_force_n,
    square_edge_v,
    square_harmonic_force_n,
    square_mean_force_n,
    step_impulse_n_s,
    step_voltage_v,
)
from hypothesis import given, strategies as st
from scipy.integrate import solve_ivp

from tactometry.stimuli.electrovibration import PulseTrain, Sine, Skin, Square, Step, Trapezoid, electrostatic_force_n
from tactometry.stimuli.electrovibration.attraction.force import force_per_square_volt_n
from tactometry.stimuli.electrovibration.skin.relaxation import Relaxations, Solution
from tactometry.stimuli.electrovibration.waveforms.pieces import Pieces, straight

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


@pytest.mark.parametrize("body_ohm", [1e-6, 1e-3])
def test_a_small_body_resistance_tends_to_none(body_ohm: float) -> None:
    frequencies_hz = [0.0, 1.0, 60.0, 1e4]
    np.testing.assert_allclose(
        Skin(body_resistance_ohm=body_ohm).response(frequencies_hz), P0.response(frequencies_hz), atol=1e-6
    )


@given(rho=st.one_of(st.sampled_from([0.0, np.inf]), positive), body_ohm=st.sampled_from([0.0, 1e-9, 1e3, 1e9]))
def test_force_is_finite_and_nonnegative_at_any_resistivity(rho: float, body_ohm: float) -> None:
    skin = Skin(corneum_resistivity_ohm_m=rho, body_resistance_ohm=body_ohm)
    force_n = sc_force_n(np.array([100.0, -100.0, 0.0, 3.0]), 1e4, skin)
    assert np.isfinite(force_n).all()
    assert (force_n >= 0).all()


END_S, PEAK_V, TOLERANCE = 0.02, 100.0, 1e-12
INPUTS = {
    "sine": Sine(frequency_hz=240.0, ramp_s=0.0, duration_s=END_S),
    "step": Step(onset_s=1e-3, duration_s=END_S),
    "trapezoid": Trapezoid(rise_s=1e-3, high_s=3e-3, fall_s=1e-3, low_s=3e-3, low_ratio=-0.5, duration_s=END_S),
    "square": Square(frequency_hz=120.0, ramp_s=0.0, duration_s=END_S),
    "pulses": PulseTrain(frequency_hz=120.0, width_s=1e-3, ramp_s=0.0, duration_s=END_S, polarity="alternating"),
}


def integrated_v(skin: Skin, pieces: Pieces, t_s: np.ndarray) -> np.ndarray:
    """Corneum voltage (n_times,) of insulator, corneum and body by an adaptive solver, piece by piece, from rest."""
    c_i, c_s = skin.insulator_capacitance_f(AREA_M2), skin.corneum_capacitance_f(AREA_M2)
    r_s, r_b = skin.corneum_resistance_ohm(AREA_M2), skin.body_resistance_ohm
    state, found_v = np.zeros(2), np.empty(t_s.size)
    for i, (start, end) in enumerate(zip(pieces.starts_s, [*pieces.starts_s[1:], pieces.end_s], strict=True)):

        def slope(t: float, v: np.ndarray, i: int = i) -> list[float]:
            applied_v = pieces.value_in(np.array(i), np.array(t))
            current_a = (applied_v - v[0] - v[1]) / r_b
            return [current_a / c_i, (current_a - v[1] / r_s) / c_s]

        inside = (t_s >= start) & (t_s < end if end < pieces.end_s else t_s <= end)
        at_s = np.unique(np.r_[t_s[inside], end])
        run = solve_ivp(slope, (start, end), state, t_eval=at_s, method="DOP853", rtol=TOLERANCE, atol=TOLERANCE)
        found_v[inside], state = run.y[1][: inside.sum()], run.y[:, -1]
    return found_v


@pytest.mark.parametrize("name", INPUTS)
def test_exact_solution_matches_adaptive_solver(name: str) -> None:
    skin, pieces = Skin(body_resistance_ohm=1e5), INPUTS[name].pieces(40.0)
    t_s = np.linspace(0, END_S, 101)
    found_v = Solution(pieces, skin.relaxations(AREA_M2)).at(t_s)
    np.testing.assert_allclose(found_v, integrated_v(skin, pieces, t_s), rtol=0, atol=10 * TOLERANCE * PEAK_V)
    assert np.abs(found_v).max() > 10


def test_sampled_voltage_with_body_resistance_matches_adaptive_solver() -> None:
    skin, t_s = Skin(body_resistance_ohm=1e4), np.arange(500) / 1e6
    found_v = corneum_voltage_v(np.full(500, 100.0), 1e6, skin, AREA_M2)
    expected_v = integrated_v(skin, straight([0.0, t_s[-1]], [100.0, 100.0]), t_s)
    np.testing.assert_allclose(found_v, expected_v, rtol=0, atol=1e-8)


def test_infinite_relaxation_rate_passes_no_sample() -> None:
    assert not Relaxations((1.0,), (np.inf,)).sampled(np.array([5.0, 1.0, -3.0]), 1e3).any()


def test_corneum_bears_no_constant_voltage() -> None:
    assert P0.gain(0.0) == 0


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
