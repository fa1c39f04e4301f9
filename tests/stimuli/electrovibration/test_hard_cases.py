"""Named hard cases, each with its reference."""

from itertools import pairwise

import mpmath as mp
import numpy as np
import pytest
from corneum_closed_form import corneum_voltage_v, rise_peak_v, step_voltage_v
from hard_cases import hard_case

from tactometry.stimuli.electrovibration import (
    CoulombFriction,
    Finger,
    PulseTrain,
    Sine,
    Skin,
    Square,
    Step,
    Trapezoid,
    electrostatic_force_n,
    sliding,
)
from tactometry.stimuli.electrovibration.attraction.force import force_form
from tactometry.stimuli.electrovibration.attraction.offset import WithOffset
from tactometry.stimuli.electrovibration.skin.relaxation import Relaxations, Solution, high_passed

AREA_M2 = 1e-4
P0 = Skin()


def layer_force_n(voltage_v: np.ndarray, skin: Skin = P0, rate_hz: float = 1e4, area_m2: float = AREA_M2) -> np.ndarray:
    return electrostatic_force_n(voltage_v, rate_hz=rate_hz, skin=skin, area_m2=area_m2, law="sc_layer")


@pytest.mark.parametrize("tau_s", np.geomspace(1e-9, 1e3, 13))
def test_tau_from_a_nanosecond_to_a_thousand_seconds(tau_s: float) -> None:
    rate_per_s, rate_hz = 1 / tau_s, 1e5
    voltage_v = np.array([0.0, 1.0, 4.0, 4.0, -2.0, -2.0, 0.0, 0.0])
    found_v = Relaxations((1.0,), (rate_per_s,)).sampled(voltage_v, rate_hz)
    with mp.workdps(50):
        x = mp.mpf(rate_per_s) / mp.mpf(rate_hz)
        state, expected_v = mp.mpf(0), [0.0]
        for step_v in np.diff(voltage_v):
            state = state * mp.exp(-x) + mp.mpf(step_v) * (1 - mp.exp(-x)) / x
            expected_v.append(float(state))
    hard_case("skin with tau of 1 ns to 1000 s", found_v, expected_v, 1e-13, against="50 digits", floor=0.01)


def test_resistivity_0_leaves_no_voltage_on_the_corneum() -> None:
    conductor = Skin(corneum_resistivity_ohm_m=0.0)
    assert not layer_force_n(np.array([100.0, -100.0]), conductor).any()
    assert conductor.gain(1e6) == 0
    pressed_n = electrostatic_force_n([100.0], rate_hz=1.0, skin=conductor, area_m2=AREA_M2, law="interface")
    plates_n = electrostatic_force_n([100.0], rate_hz=1.0, skin=conductor, area_m2=AREA_M2, law="parallel_plate")
    hard_case("conducting skin", pressed_n, plates_n * P0.insulator_permittivity, 1e-14, against="two plates")


def test_resistivity_limits_are_reached() -> None:
    voltage_v = np.array([100.0, 50.0, -30.0])
    for rho, limit in ((1e-15, 0.0), (1e25, np.inf)):
        near_n = layer_force_n(voltage_v, Skin(corneum_resistivity_ohm_m=rho))
        limit_n = layer_force_n(voltage_v, Skin(corneum_resistivity_ohm_m=limit))
        hard_case("resistivity of 1e-15 and 1e25", near_n[1:], limit_n[1:], 1e-12, against="the limits", floor=1e-8)


@pytest.mark.parametrize("body_ohm", [0.0, 1e3])
def test_area_to_0_is_regular_down_to_0(body_ohm: float) -> None:
    skin, voltage_v = Skin(body_resistance_ohm=body_ohm), np.array([100.0, 80.0, -10.0])
    assert not layer_force_n(voltage_v, skin, area_m2=0.0).any()
    densities = [layer_force_n(voltage_v, skin, area_m2=a)[1:] / a for a in (1e-12, 1e-100, 1e-290)]
    hard_case("contact area of 1e-290 m2", densities[2], densities[1], 1e-12, against="1e-100 m2")
    np.testing.assert_allclose(densities[0], densities[1], rtol=1e-6)


def test_gap_to_0_is_continuous() -> None:
    step_v = np.array([100.0, 100.0, 100.0])
    for law in ("interface", "sc_layer"):
        none_n, small_n = (
            electrostatic_force_n(step_v, rate_hz=1e4, skin=Skin(gap_m=g), area_m2=AREA_M2, law=law)
            for g in (0.0, 1e-18)
        )
        hard_case("air gap of 1e-18 m", small_n, none_n, 1e-10, against="no gap")


@pytest.mark.parametrize("permittivity", [1.0, 1e6])
def test_permittivity_1_and_a_million(permittivity: float) -> None:
    skin = Skin(corneum_permittivity=permittivity)
    shares = [P0.insulator_thickness_m / P0.insulator_permittivity, 200e-6 / permittivity]
    assert skin.k == pytest.approx(shares[1] / sum(shares), rel=1e-15)
    found_v = corneum_voltage_v(np.full(50, 100.0), 1e4, skin, AREA_M2)
    exact_v = step_voltage_v(np.arange(50) / 1e4, 100.0, skin)
    hard_case("permittivity of 1 and of a million", found_v, exact_v, 1e-12, against="closed form", floor=1e-288)


def test_a_rise_of_1_nanosecond() -> None:
    pieces = Step(rise_s=1e-9, duration_s=0.1).pieces(40.0)
    found_v = Solution(pieces, P0.relaxations(AREA_M2)).at([1e-9, 1e-3])
    with mp.workdps(40):
        tau, k = mp.mpf(P0.tau_s), mp.mpf(P0.k)
        peak = 100 * k * tau / mp.mpf(1e-9) * (1 - mp.exp(-mp.mpf(1e-9) / tau))
        expected_v = [float(peak), float(peak * mp.exp(-(mp.mpf(1e-3) - mp.mpf(1e-9)) / tau))]
    hard_case("rise of 1 ns", found_v, expected_v, 1e-13, against="40 digits")
    assert float(rise_peak_v(1e-9, 100.0, P0)) == pytest.approx(expected_v[0], rel=1e-15)


@pytest.mark.parametrize("tau_s", [315e-6, 1e3])
def test_10_seconds_at_1_megahertz_without_drift(tau_s: float) -> None:
    n, decay = 10_000_000, 1 / (tau_s * 1e6)
    steps = np.zeros(n)
    steps[0] = 1.0
    found = high_passed(steps, decay)
    at = np.array([1, 1000, n // 2, n - 1])
    with mp.workdps(40):
        expected = [float(mp.exp(-mp.mpf(decay) * int(i))) for i in at]
    hard_case("10 s at 1 MHz", found[at], expected, 2e-12, against="40 digits", floor=1e-288)


def test_long_sine_ends_in_its_steady_state() -> None:
    rate_hz, n = 1e6, 10_000_000
    tone_v = np.sin(2 * np.pi * ((np.arange(n) * 240) % 1_000_000) / 1e6)
    found_v = corneum_voltage_v(tone_v, rate_hz, P0, AREA_M2)[-4167:]
    early_v = corneum_voltage_v(tone_v[:1_000_000], rate_hz, P0, AREA_M2)[-4167:]
    hard_case("10 s of a sine at 1 MHz", found_v, early_v, 1e-12, against="its steady state", floor=1)


def test_a_normal_force_of_0_and_of_1_kilonewton() -> None:
    pieces, form = Sine(frequency_hz=60.0, duration_s=0.1).pieces(40.0), force_form("sc_layer", P0, AREA_M2)
    t_s = np.linspace(0, 0.1, 101)
    none, large = (
        sliding(t_s, pieces, form, finger=Finger(), friction=CoulombFriction(), force_n=f) for f in (0.0, 1e3)
    )
    np.testing.assert_array_equal(none.lateral_n, 0.5 * none.electrostatic_n)
    hard_case("normal force of 1 kN", large.lateral_n, 0.5 * (1e3 + large.electrostatic_n), 1e-15, against="Coulomb")


def test_band_limited_square_near_nyquist_is_a_sine() -> None:
    square = Square(frequency_hz=9_000.0, rate_hz=20_000.0, ramp_s=0.0, band_limited=True, duration_s=0.01)
    tone = np.sin(2 * np.pi * 9_000.0 * np.arange(200) / 20_000)
    hard_case("band-limited square below Nyquist", square.at(0.0).samples[0], tone, 1e-6, against="a sine", floor=1)


def test_voltage_0_and_1_kilovolt() -> None:
    silent = Sine(frequency_hz=60.0, level_unit="V").at(0.0)
    assert silent.peak == 0
    assert not layer_force_n(silent.samples[0]).any()
    kilovolt_n, scaled_n = layer_force_n(np.array([1000.0])), 100 * layer_force_n(np.array([100.0]))
    hard_case("1 kV", kilovolt_n, scaled_n, 1e-14, against="the square of the voltage")


def pulsed_v(corners: list[tuple[float, float]], period_s: mp.mpf, before_s: mp.mpf) -> float:
    """Return the steady corneum voltage shortly before a period ends.

    The 100 V drive consists of lines between corners (time, voltage per volt).
    """
    tau_s, total = mp.mpf(P0.tau_s), mp.mpf(0)
    for (start_s, low), (end_s, high) in pairwise(corners):
        span = end_s - start_s
        left = mp.exp(-(period_s - before_s - end_s) / tau_s)
        total += (high - low) * left * (1 if span == 0 else (1 - mp.exp(-span / tau_s)) * tau_s / span)
    return float(100 * mp.mpf(P0.k) * total / (1 - mp.exp(-period_s / tau_s)))


MANY = {"frequency_hz": 1e5, "width_s": 2e-6, "duration_s": 10.0, "ramp_s": 0.0, "rate_hz": 1e6}
PULSES = [
    (PulseTrain(**MANY, polarity="positive"), 1e-5, [(0, 0), (0, 1), (2, 1), (2, 0)]),
    (PulseTrain(**MANY, polarity="alternating"), 2e-5, [(0, 0), (0, 1), (2, 1), (2, 0), (10, 0), (10, -1), (12, -1),
                                                        (12, 0)]),
    (Trapezoid(2e-6, 0.0, 4e-6, 4e-6, low_ratio=-0.5, duration_s=10.0, rate_hz=1e6), 1e-5, [(0, -0.5), (2, 1),
                                                                                          (6, -0.5)]),
]  # fmt: skip


@pytest.mark.parametrize(("train", "period_s", "corners"), PULSES)
def test_a_million_pulses(train: PulseTrain | Trapezoid, period_s: float, corners: list[tuple[int, float]]) -> None:
    pieces = train.pieces(40.0)
    assert len(pieces.starts_s) >= 2_000_000
    late_s = 10.0 - period_s - 1e-9
    found_v = Solution(pieces, P0.relaxations(AREA_M2)).at(late_s)
    with mp.workdps(40):
        micro_s = mp.mpf(10) ** -6
        whole_s = round(1e6 * period_s) * micro_s
        exact = [(t * micro_s, value) for t, value in corners]
        expected_v = pulsed_v(exact, whole_s, 10 - whole_s - mp.mpf(late_s))
    assert abs(expected_v) > 0.1
    # A double resolves 10 s to 1.8e-15 s, which is 1e-9 of a pulse of 2 us.
    hard_case("a million pulses", found_v, expected_v, 1e-9, against="closed form in 40 digits")


@pytest.mark.parametrize("ratio", [0.5, -3.0])
def test_nonzero_mean_voltage_is_blocked_in_steady_state(ratio: float) -> None:
    shifted = WithOffset(Sine(frequency_hz=60.0, ramp_s=0.0), ratio)
    plain_v = Solution(Sine(frequency_hz=60.0, ramp_s=0.0).pieces(40.0), P0.relaxations(AREA_M2))
    shifted_v = Solution(shifted.pieces(40.0), P0.relaxations(AREA_M2))
    late_s = np.linspace(40 * P0.tau_s, 0.5, 301)
    blocked_v = (1 + abs(ratio)) * shifted_v.at(late_s)
    hard_case("a mean that is blocked", blocked_v, plain_v.at(late_s), 1e-12, against="no mean", floor=1)


@pytest.mark.parametrize("kind", [Sine, Square])
def test_tone_just_below_nyquist_keeps_its_peak(kind: type) -> None:
    assert kind(frequency_hz=9_999.0, rate_hz=20_000.0).at(20.0).peak <= 10
