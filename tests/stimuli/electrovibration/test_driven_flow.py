"""The flow of a driven system, against its matrix exponential."""

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, strategies as st
from numba import njit

from tactometry.stimuli.electrovibration import AmplitudeModulated, Finger, Sine, Skin, Step, Trapezoid
from tactometry.stimuli.electrovibration.attraction.force import force_form
from tactometry.stimuli.electrovibration.motion.compiled_loops import march, states
from tactometry.stimuli.electrovibration.motion.driven_motion import (
    Circuit,
    LinearSystem,
    Timing,
    circuit_states,
    first_order_response,
    flows,
    plan_of,
)
from tactometry.stimuli.electrovibration.motion.phases import heights
from tactometry.stimuli.electrovibration.skin.relaxation import Relaxations
from tactometry.stimuli.electrovibration.waveforms.pieces import Pieces

RATE_PER_S = 1e3
LAG = LinearSystem(((-4335.0,),), (2167.0,))
TWICE = LinearSystem(((-2 * RATE_PER_S,),), (1.0,))
"""As fast as the square of a relaxation: there a sum of exponentials would divide by 0."""
TONES = {
    "step": Step(duration_s=0.02).pieces(40.0),
    "trapezoid": Trapezoid(rise_s=1e-3, high_s=5e-3, fall_s=1e-3, low_s=5e-3, duration_s=0.02).pieces(40.0),
    "sine": Sine(frequency_hz=240.0, ramp_s=5e-3, duration_s=0.02).pieces(40.0),
    "carrier": AmplitudeModulated(frequency_hz=240.0, ramp_s=5e-3, duration_s=0.02).pieces(40.0),
}
T_S = np.linspace(0.0, 0.02, 401)
LAWS = ["sc_layer", "total_thickness"]
STATES, MARCH = njit(states), njit(march)


def lifted(circuit: Circuit, system: LinearSystem, length_s: float) -> mp.matrix:
    """Return the linear flow of (all products z_i z_j, x) in 40 digits."""
    z, g, n = circuit.matrix(), circuit.output(), circuit.n_states
    one = np.eye(n)
    products = np.kron(z, one) + np.kron(one, z)
    zeros = np.zeros((n * n, len(system.input)))
    pulled = np.hstack([np.outer(system.input, np.outer(g, g).ravel()), np.array(system.matrix)])
    with mp.workdps(40):
        whole = mp.matrix(np.vstack([np.hstack([products, zeros]), pulled]).tolist()) * mp.mpf(length_s)
        return mp.expm(whole, method="taylor")


@pytest.mark.parametrize("system", [LAG, TWICE, Finger().system], ids=["lag", "twice", "pad"])
@pytest.mark.parametrize("active", [(True, True), (True, False)])
@pytest.mark.parametrize("length_s", [1e-7, 5.4e-6, 3e-3])
def test_a_flow_is_the_exponential_of_its_equation(
    system: LinearSystem, active: tuple[bool, bool], length_s: float
) -> None:
    circuit = Circuit(Relaxations((0.4, 0.3), (RATE_PER_S, 2e4), 0.1), (2120.0,), True, active)
    flow, expected = flows(circuit, system, np.array([length_s, 2 * length_s])), lifted(circuit, system, length_s)
    n, products = len(system.input), circuit.n_states**2
    rows = np.array(expected.tolist(), dtype=float)[-n:]
    for found, wanted in ((flow.states[0], rows[:, products:]), (flow.forms[0].reshape(n, -1), rows[:, :products])):
        size = np.abs(wanted).max(axis=1, keepdims=True)
        np.testing.assert_allclose(found / size, wanted / size, rtol=0, atol=1e-13)


@given(st.floats(1e-9, 1e-1), st.floats(1e-9, 1e-1))
def test_flows_over_two_lengths_make_one_over_both(first_s: float, second_s: float) -> None:
    circuit = Circuit(Relaxations((0.4,), (RATE_PER_S,)), (240.0,), False, (True,))
    flow = flows(circuit, LAG, np.array([first_s, second_s, first_s + second_s]))
    (a, b, both), (f, g, h), (one, _, _) = flow.states, flow.forms, np.eye(3) + flow.change
    np.testing.assert_allclose(both, b @ a, rtol=1e-10, atol=1e-300)
    np.testing.assert_allclose(h[0], b[0, 0] * f[0] + one.T @ g[0] @ one, rtol=0, atol=1e-10 * np.abs(h).max())


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("pieces", TONES.values(), ids=TONES)
def test_state_flow_matches_compiled_loop(pieces: Pieces, law: str) -> None:
    form = force_form(law, Skin(), 1e-4)
    plan = plan_of(Timing(pieces, T_S), form.relaxations, LAG)
    z = STATES(heights(pieces), plan)
    np.testing.assert_allclose(circuit_states(pieces, form.relaxations, plan), z, rtol=0, atol=1e-13 * np.abs(z).max())
    expected = MARCH(z, form.newton_per_v2, plan)[0, plan.wanted]
    found = first_order_response(pieces, form, LAG, T_S)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13 * np.abs(expected).max())
