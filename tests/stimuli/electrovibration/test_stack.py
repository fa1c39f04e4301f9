"""Series of leaky layers, against closed forms and solvers."""

import mpmath as mp
import numpy as np
import pytest
from examples import examples
from hard_cases import hard_case
from hypothesis import example, given, strategies as st

from tactometry.stimuli.defaults import VACUUM_PERMITTIVITY_F_PER_M as E0
from tactometry.stimuli.electrovibration import Layer, Skin, Stack
from tactometry.stimuli.electrovibration.skin.relaxation import Solution
from tactometry.stimuli.electrovibration.skin.stack import DispersiveLayer
from tactometry.stimuli.electrovibration.waveforms.pieces import straight

AREA_M2 = 1e-4
leaky = st.builds(
    Layer,
    thickness_m=st.floats(1e-8, 1e-2),
    permittivity=st.floats(1, 1e6),
    resistivity_ohm_m=st.one_of(st.floats(1e-3, 1e15), st.just(np.inf)),
)


def test_two_leaky_layers_after_a_step() -> None:
    one, two = Layer(1e-5, 50.0, 1e7), Layer(2e-4, 1000.0, 2e4)
    c = [AREA_M2 / layer.elastance_m2_per_f for layer in (one, two)]
    r = [layer.resistivity_ohm_m * layer.thickness_m / AREA_M2 for layer in (one, two)]
    tau_s = (c[0] + c[1]) * r[0] * r[1] / (r[0] + r[1])
    solved = Solution(straight([0, 10 * tau_s], [5, 5]), Stack((one, two)).relaxations(1, AREA_M2))
    t_s = np.linspace(0, 10 * tau_s, 50)
    start_v, end_v = 5 * c[0] / (c[0] + c[1]), 5 * r[1] / (r[0] + r[1])
    expected_v = end_v + (start_v - end_v) * np.exp(-t_s / tau_s)
    np.testing.assert_allclose(solved.at(t_s), expected_v, rtol=1e-12)


LIKE_AND_UNLIKE = [Layer(0.004718329575630888, 1.0, 1.75), Layer(0.004718329575630888)]


@given(layers=st.lists(leaky, min_size=1, max_size=5), body_ohm=st.sampled_from([0.0, 1.0, 1e3, 1e9]))
@example(layers=LIKE_AND_UNLIKE, body_ohm=0.0)
@examples(200)
def test_the_relaxations_are_the_ratio_of_impedances(layers: list[Layer], body_ohm: float) -> None:
    stack = Stack(tuple(layers), body_ohm)
    for frequency_hz in (1e-3, 1.0, 250.0, 1e5):
        expected = _ratios(layers, body_ohm, frequency_hz)
        for index in range(len(layers)):
            found = complex(stack.response(frequency_hz, index, AREA_M2))
            largest = sum(abs(g) for g in stack.relaxations(index, AREA_M2).gains) + abs(expected[index])
            assert abs(found - expected[index]) <= 1e-10 * largest + 1e-14


def _ratios(layers: list[Layer], body_ohm: float, frequency_hz: float) -> list[complex]:
    with mp.workdps(60):
        p = 2j * mp.pi * mp.mpf(frequency_hz)
        z = [
            mp.mpf(layer.thickness_m)
            / (AREA_M2 * (1 / mp.mpf(layer.resistivity_ohm_m) + p * mp.mpf(E0) * mp.mpf(layer.permittivity)))
            for layer in layers
        ]
        return [complex(one / (mp.mpf(body_ohm) + sum(z))) for one in z]


@given(layers=st.lists(leaky, min_size=1, max_size=5), area_m2=st.sampled_from([1e-300, 1e-9, 1.0]))
def test_the_layers_share_the_voltage_between_them(layers: list[Layer], area_m2: float) -> None:
    stack = Stack(tuple(layers))
    step = straight([0, 1.0], [3.0, 3.0])
    t_s = np.geomspace(1e-12, 1, 20)
    total_v = sum(Solution(step, stack.relaxations(i, area_m2)).at(t_s) for i in range(len(layers)))
    np.testing.assert_allclose(total_v, 3.0, rtol=1e-9)


@given(layers=st.lists(leaky, min_size=2, max_size=4), body_ohm=st.sampled_from([0.0, 1e3]))
def test_rates_are_positive_and_interlace_those_of_the_layers(layers: list[Layer], body_ohm: float) -> None:
    rates = Stack(tuple(layers), body_ohm).relaxations(0, AREA_M2).rates_per_s
    own = sorted({layer.rate_per_s for layer in layers})
    assert len(rates) == len(own) - 1 + (body_ohm > 0)
    for low, rate, high in zip(own, rates, [*own[1:], np.inf], strict=False):
        assert low <= rate <= high


@pytest.mark.parametrize("tau_s", [1e-9, 1e-6, 315e-6, 1.0, 1e3])
@pytest.mark.parametrize("body_ohm", [0.0, 1e3])
def test_the_exact_voltage_of_a_trapezoid_against_50_digits(tau_s: float, body_ohm: float) -> None:
    rho = tau_s / (Skin().tau_s / 2e4)
    skin = Skin(corneum_resistivity_ohm_m=rho, body_resistance_ohm=body_ohm)
    times_s, values_v = [0.0, 1e-3, 5e-3, 5.5e-3, 0.02], [0.0, 100.0, 100.0, -50.0, -50.0]
    at_s = [1e-9, 5e-4, 1e-3, 1.0005e-3, 4e-3, 5.2e-3, 0.02]
    found_v = Solution(straight(times_s, values_v), skin.relaxations(AREA_M2)).at(at_s)
    expected_v = [_reference_v(skin, times_s, values_v, t) for t in at_s]
    hard_case("layers with a body resistance", found_v, expected_v, 1e-11, against="50 digits", floor=1e-3)


def _reference_v(skin: Skin, times_s: list[float], values_v: list[float], t_s: float) -> float:
    """Return the corneum voltage as an exact 50-digit sum over kinks."""
    with mp.workdps(50):
        c_i, c_s = mp.mpf(skin.insulator_capacitance_f(AREA_M2)), mp.mpf(skin.corneum_capacitance_f(AREA_M2))
        r_s, r_b = mp.mpf(skin.corneum_resistance_ohm(AREA_M2)), mp.mpf(skin.body_resistance_ohm)
        a, b = c_i * r_b * r_s * c_s, c_i * r_b + r_s * (c_i + c_s)
        if a == 0:
            terms = [(c_i * r_s / b, 1 / b)]
        else:
            root = mp.sqrt(b**2 - 4 * a)
            terms = [(c_i * r_s / root, (b - root) / (2 * a)), (-c_i * r_s / root, (b + root) / (2 * a))]
        slopes = np.diff(values_v) / np.diff(times_s)
        kinks = zip(times_s, np.diff(slopes, prepend=0.0), strict=False)
        total = sum(
            kink * gain * (1 - mp.exp(-rate * (mp.mpf(t_s) - mp.mpf(start)))) / rate
            for start, kink in kinks
            for gain, rate in terms
            if t_s > start
        )
        return float(total)


def test_properties_interpolate_logarithmically_between_rows() -> None:
    table = DispersiveLayer(1e-4, (1.0, 100.0), (1e4, 1e2), (1e6, 1e2))
    permittivity, resistivity = table.properties([0.1, 10.0, 1e4])
    np.testing.assert_allclose(permittivity, [1e4, 1e3, 1e2], rtol=1e-12)
    np.testing.assert_allclose(resistivity, [1e6, 1e4, 1e2], rtol=1e-12)


def test_deeper_tissue_is_a_layer_of_the_stack() -> None:
    tissue = Layer(5e-3, 3e4, 100.0)
    skin = Skin(tissue=tissue, body_resistance_ohm=100.0)
    f_hz = [10.0, 240.0, 1e5]
    expected = _ratios([*Skin().stack.layers[::2], tissue], 100.0, 240.0)[1]
    assert complex(skin.response(240.0, AREA_M2)) == pytest.approx(expected, rel=1e-12)
    assert (skin.gain(f_hz, AREA_M2) < Skin().gain(f_hz, AREA_M2)).all()


def test_purely_resistive_tissue_equals_body_resistance() -> None:
    tissue = Skin(tissue=Layer(5e-3, 1.0, 20.0))
    body = Skin(body_resistance_ohm=20.0 * 5e-3 / AREA_M2)
    f_hz = [1.0, 60.0, 1e3, 1e5]
    np.testing.assert_allclose(tissue.response(f_hz, AREA_M2), body.response(f_hz, AREA_M2), rtol=1e-3)


@pytest.mark.parametrize("gap_m", [1e-7, 5e-6])
def test_gap_skin_share_and_time_constant_match_stack(gap_m: float) -> None:
    skin = Skin(gap_m=gap_m)
    found = skin.relaxations(AREA_M2)
    assert found.gains[0] == pytest.approx(skin.k, rel=1e-13)
    assert 1 / found.rates_per_s[0] == pytest.approx(skin.tau_s, rel=1e-13)
