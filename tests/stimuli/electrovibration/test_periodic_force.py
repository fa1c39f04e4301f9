"""Force in the periodic steady state of layers whose properties depend on frequency."""

import numpy as np
import pytest
from corneum_closed_form import square_mean_force_n

from tactometry.errors import InvalidParameter
from tactometry.stimuli.defaults import VACUUM_PERMITTIVITY_F_PER_M as E0
from tactometry.stimuli.electrovibration import (
    DispersiveLayer,
    Layer,
    Skin,
    Square,
    Stack,
    electrostatic_force_n_at,
    periodic_force_n,
)
from tactometry.stimuli.electrovibration.waveforms.pieces import Pieces

AREA_M2, N = 1e-4, 512
GLASS, TISSUE = Layer(1e-6, 3.9), Layer(5e-3, 1e4, 2.0)
P0_CORNEUM = Layer(200e-6, 1000.0, 2e4)
TABLE = DispersiveLayer(200e-6, (10.0, 100.0, 1000.0), (4e3, 2e3, 1e3), (1e5, 6e4, 2e4))
PHASE = 2 * np.pi * np.arange(N) / N


def force_n(voltage_v, rate_hz: float, law: str, corneum=TABLE, **changes) -> np.ndarray:
    given = {"insulator": GLASS, "corneum": corneum, "area_m2": AREA_M2, "law": law, **changes}
    return periodic_force_n(voltage_v, rate_hz, **given)


@pytest.mark.parametrize("law", ["interface", "sc_layer"])
@pytest.mark.parametrize("body_ohm", [0.0, 1e4])
def test_constant_properties_give_the_steady_state_of_the_exact_solution(law: str, body_ohm: float) -> None:
    skin = Skin(body_resistance_ohm=body_ohm, tissue=TISSUE)
    f_hz, c = np.array([60.0, 180.0]), np.array([[-100j, 30.0]])
    tones = Pieces(np.zeros(1), 1.0, np.array([7.0]), np.zeros(1), f_hz, c)
    voltage_v = tones.at(PHASE / (2 * np.pi * 60))
    found_n = force_n(voltage_v, N * 60.0, law, P0_CORNEUM, deeper=(TISSUE,), resistance_ohm=body_ohm)
    exact_n = electrostatic_force_n_at(0.5 + PHASE / (2 * np.pi * 60), tones, skin=skin, area_m2=AREA_M2, law=law)
    np.testing.assert_allclose(found_n, exact_n, rtol=0, atol=1e-11 * exact_n.max())


@pytest.mark.parametrize(("f_hz", "permittivity", "rho"), [(10.0, 4e3, 1e5), (100.0, 2e3, 6e4), (1000.0, 1e3, 2e4)])
def test_a_single_line_meets_the_law_with_the_properties_of_its_frequency(f_hz, permittivity, rho) -> None:
    skin = Skin(corneum_permittivity=permittivity, corneum_resistivity_ohm_m=rho)
    h = complex(skin.response(f_hz, AREA_M2))
    corneum_v = 100 * abs(h) * np.sin(PHASE + np.angle(h))
    expected_n = E0 * permittivity * AREA_M2 / 2 * (corneum_v / 200e-6) ** 2
    found_n = force_n(100 * np.sin(PHASE), N * f_hz, "sc_layer")
    np.testing.assert_allclose(found_n, expected_n, rtol=0, atol=1e-12 * expected_n.max())


def test_the_spectrum_of_the_square_holds_sums_and_differences_of_the_lines() -> None:
    voltage_v = 100 * np.cos(PHASE) + 50 * np.cos(10 * PHASE)
    lines_n = np.fft.rfft(force_n(voltage_v, N * 10.0, "interface")) / N
    insulator_v = [
        height * complex(Stack((GLASS, Layer(200e-6, e, rho))).response(f, 0, AREA_M2))
        for height, f, e, rho in ((100, 10.0, 4e3, 1e5), (50, 100.0, 2e3, 6e4))
    ]
    one, ten = insulator_v
    per_v2 = E0 * AREA_M2 / 2 * (3.9 / 1e-6) ** 2
    expected_n = np.zeros(N // 2 + 1, complex)
    expected_n[[0, 2, 20]] = (abs(one) ** 2 + abs(ten) ** 2) / 2, one**2 / 4, ten**2 / 4
    expected_n[[9, 11]] = ten * np.conj(one) / 2, ten * one / 2
    np.testing.assert_allclose(lines_n, per_v2 * expected_n, rtol=0, atol=1e-12 * abs(expected_n[0]) * per_v2)


def test_in_sc_layer_each_line_has_the_permittivity_of_its_frequency() -> None:
    rows = ((100, 1, 10.0, 4e3, 1e5), (50, 10, 100.0, 2e3, 6e4))
    field_v_per_m, displacement = np.zeros(N), np.zeros(N)
    for height_v, harmonic, f_hz, permittivity, rho in rows:
        h = complex(Stack((GLASS, Layer(200e-6, permittivity, rho))).response(f_hz, 1, AREA_M2))
        line = height_v * (h * np.exp(1j * harmonic * PHASE)).real / 200e-6
        field_v_per_m += line
        displacement += E0 * permittivity * line
    voltage_v = 100 * np.cos(PHASE) + 50 * np.cos(10 * PHASE)
    expected_n = AREA_M2 / 2 * field_v_per_m * displacement
    found_n = force_n(voltage_v, N * 10.0, "sc_layer")
    np.testing.assert_allclose(found_n, expected_n, rtol=0, atol=1e-12 * expected_n.max())


def test_the_mean_force_of_a_square_is_the_closed_form() -> None:
    n = 2**17
    voltage_v = Square(frequency_hz=60.0, ramp_s=0.0).corners.at(np.arange(n) / n) * 100
    found_n = force_n(voltage_v, n * 60.0, "sc_layer", P0_CORNEUM)
    assert found_n.mean() == pytest.approx(float(square_mean_force_n(60.0, 100.0, Skin(), AREA_M2)), rel=1e-4)


def test_a_table_changes_the_force_where_the_voltage_has_its_lines() -> None:
    low_n, high_n = (
        force_n(100 * np.sin(PHASE), N * f_hz, "sc_layer").mean()
        / force_n(100 * np.sin(PHASE), N * f_hz, "sc_layer", P0_CORNEUM).mean()
        for f_hz in (10.0, 1000.0)
    )
    assert low_n > 10
    assert high_n == pytest.approx(1, rel=1e-12)


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: force_n([1.0, -1.0], 1e3, "parallel_plate"), "found parallel_plate, which has no term for leakage"),
        (lambda: force_n([1.0, -1.0], 1e3, None), "law: found none"),
        (lambda: force_n([1.0], 1e3, "interface", insulator=P0_CORNEUM), "expected a thickness above 0 and no leakage"),
        (lambda: force_n([1.0], 1e3, "sc_layer", Layer(0.0)), "corneum: found a thickness of 0 m"),
        (lambda: force_n([[1.0]], 1e3, "sc_layer"), "expected one period"),
    ],
)
def test_what_has_no_force_is_refused(call, sentence: str) -> None:
    with pytest.raises(InvalidParameter, match=sentence):
        call()
