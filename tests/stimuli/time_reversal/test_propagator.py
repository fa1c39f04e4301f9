"""Exact steps of the modes under a force that is linear between samples, against 40-digit arithmetic."""

import math

import numpy as np
import pytest
from hard_cases import hard_case
from mpmath import expm as mp_expm, matrix, mp, mpf

from tactometry.stimuli.time_reversal.plate.oscillators import Oscillators
from tactometry.stimuli.time_reversal.plate.propagator import linear_input, run_impulses, run_linear, transition

STEP_S = 1e-5
CASES = {
    "mid band": (1.5e5, 285.7),
    "omega h = pi": (math.pi / STEP_S, 100.0),
    "omega h = 30": (30 / STEP_S, 100.0),
    "no loss": (1.5e5, 0.0),
    "critical": (1e4, 1e4),
    "next to critical": (1e4, 1e4 * (1 + 1e-9)),
    "ten times overdamped": (1e4, 1e5),
    "tau of 1 ns": (1.5e5, 1e9),
    "omega h = 1e-9": (1e-9 / STEP_S, 0.0),
    "rigid": (0.0, 0.0),
    "rigid with loss": (0.0, 300.0),
    "rigid with hardly a loss": (0.0, 0.3),
    "poles 1.6e-3 / h apart": (0.6 / STEP_S, 0.6 / STEP_S * (1 + 3.5e-6)),
    "omega h just inside the series": (0.499 / STEP_S, 100.0),
}


def exact_step(omega: float, decay: float) -> np.ndarray:
    """(2, 4): state and force weights of one step from the exponential in 40 digits."""
    mp.dps = 60
    w, a, h = mpf(omega), mpf(decay), mpf(STEP_S)
    generator = matrix([[0, h, 0, 0], [-w * w * h, -2 * a * h, h, 0], [0, 0, 0, 1], [0, 0, 0, 0]])
    whole = mp_expm(generator, method="taylor")
    rows = [[whole[i, 0], whole[i, 1], whole[i, 2] - whole[i, 3], whole[i, 3]] for i in (0, 1)]
    return np.array([[float(v) for v in row] for row in rows])


@pytest.mark.parametrize("case", [name for name in CASES if name != "tau of 1 ns"])
def test_one_step_is_exact(case):
    omega, decay = CASES[case]
    one = Oscillators(np.array([omega]), np.array([decay]))
    found = np.concatenate([transition(one, STEP_S)[0], linear_input(one, STEP_S)[0]], axis=1)
    expected = exact_step(omega, decay)
    speed = max(omega, 1 / STEP_S)
    unit = np.array([[1, 1 / speed, STEP_S**2, STEP_S**2], [speed, 1, STEP_S, STEP_S]])
    hard_case(
        "one step of a mode: omega h of 1e-9, pi and 30, critical, overdamped, rigid",
        (found - expected) / unit, 0, 1e-13, against="60 digits", floor=1,
    )  # fmt: skip


def test_nanosecond_tau_creeps_as_its_poles_predict():
    """q = (1 - (p2 e^(p1 t) - p1 e^(p2 t)) / (p2 - p1)) / w^2 under a constant force; p1 is 1e-8 of p2."""
    mp.dps = 60
    omega, decay = CASES["tau of 1 ns"]
    found = run_linear(Oscillators(np.array([omega]), np.array([decay])), np.ones((1, 400)), 1 / STEP_S)[0]
    root = mp.sqrt(mpf(decay) ** 2 - mpf(omega) ** 2)
    slow, fast = -decay + root, -decay - root
    times = [mpf(k) * mpf(STEP_S) for k in (1, 20, 399)]
    shares = [(fast * mp.exp(slow * t) - slow * mp.exp(fast * t)) / (fast - slow) for t in times]
    expected = [float((1 - share) / mpf(omega) ** 2) for share in shares]
    hard_case("tau of 1 ns under a constant force", found[[1, 20, 399]], expected, 1e-12, against="60 digits")


def test_impulses_reproduce_the_impulse_response():
    modes = Oscillators(np.array([0.0, 1e3, 1e5, 1e4]), np.array([300.0, 5e3, 300.0, 1e4]))
    impulses = np.zeros((4, 300))
    impulses[:, 0] = 1.0
    found = run_impulses(modes, impulses, 1e5, np.arange(300))
    expected = modes.impulse(1e5, 0, 300)
    assert found == pytest.approx(expected, abs=1e-12 * np.abs(expected).max())


def test_a_run_is_its_steps_with_the_weights_of_both_ends():
    oscillators = Oscillators(np.array([300.0, 2e3, 5e4]), np.array([10.0, 3e3, 500.0]))
    forces = np.random.default_rng(0).normal(size=(3, 40))
    step, weights = transition(oscillators, 1e-4), linear_input(oscillators, 1e-4)
    state, expected = np.zeros((3, 2)), [np.zeros(3)]
    for k in range(1, 40):
        state = np.einsum("nij,nj->ni", step, state) + np.einsum("nij,nj->ni", weights, forces[:, k - 1 : k + 1])
        expected.append(state[:, 0])
    assert run_linear(oscillators, forces, 1e4) == pytest.approx(np.array(expected).T, rel=1e-12, abs=1e-20)


def test_a_constant_force_ends_at_the_static_deflection():
    modes = Oscillators(np.array([1e4, 3e4]), np.array([2e3, 2e3]))
    q = run_linear(modes, np.ones((2, 5000)), 1e5)
    hard_case("constant force", q[:, -1], 1 / modes.omega_rad_per_s**2, 1e-10, against="static deflection")


def test_a_sine_on_resonance_without_loss_grows_as_the_closed_form():
    """q'' + w^2 q = sin(w t): q = (sin wt - wt cos wt) / (2 w^2); the piecewise-linear force costs
    (wh)^2/12.
    """
    omega, rate = 2e3, 1e6
    t = np.arange(20000) / rate
    q = run_linear(Oscillators(np.array([omega]), np.array([0.0])), np.sin(omega * t)[None], rate)[0]
    expected = (np.sin(omega * t) - omega * t * np.cos(omega * t)) / (2 * omega**2)
    assert q == pytest.approx(expected, abs=(omega / rate) ** 2 / 12 * np.abs(expected).max() * 1.1)
