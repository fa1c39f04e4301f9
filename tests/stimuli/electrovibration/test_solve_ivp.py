"""The exact solution, against `solve_ivp` at a tolerance of 1e-12."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tactometry.stimuli.electrovibration import PulseTrain, Sine, Skin, Square, Step, Trapezoid
from tactometry.stimuli.electrovibration.skin.relaxation import Solution
from tactometry.stimuli.electrovibration.waveforms.pieces import Pieces

AREA_M2 = 1e-4
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
