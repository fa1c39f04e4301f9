"""Oscillators: sums over modes, courses in time, and steps under a force that is linear between samples."""

import math

import numpy as np
import pytest
from hard_cases import hard_case
from hypothesis import given, settings, strategies as st
from mpmath import cos as mp_cos, cosh, exp, expm as mp_expm, matrix, mp, mpf, sin, sinh, sqrt
from scipy.special import iv

from tactometry.stimuli.time_reversal.plate import modal_sum
from tactometry.stimuli.time_reversal.plate.modal_sum import FEWEST_MODES, SHORTEST, modal_sums
from tactometry.stimuli.time_reversal.plate.oscillators import Oscillators, turns, unit_phasor
from tactometry.stimuli.time_reversal.plate.propagator import linear_input, run_impulses, run_linear, transition

RATE_HZ = 100e3


@pytest.fixture
def rng():
    return np.random.default_rng(0)


def oscillators(n=200, *, f_low_hz=10.0, f_high_hz=50e3, decay_per_s=300.0):
    omega = 2 * np.pi * np.linspace(f_low_hz, f_high_hz, n)
    return Oscillators(omega, np.broadcast_to(decay_per_s, n).astype(float))


def error(modes, weights, start, stop, quantity="displacement"):
    expected = weights @ modes.impulse(RATE_HZ, start, stop, quantity)
    found = modal_sums(modes, weights, RATE_HZ, start, stop, quantity)
    return np.abs(found - expected).max() / np.abs(expected).max()


@pytest.mark.parametrize("spread", [0.1, 2.0, 20.0])
def test_widely_varying_attenuation_keeps_precision(spread, rng):
    n_samples = 1000
    decay = 400.0 + spread / (n_samples / RATE_HZ) * np.linspace(-0.5, 5.0, 200) ** 2
    modes = oscillators(decay_per_s=decay)
    far = error(modes, rng.normal(size=(3, 200)) * modes.omega_rad_per_s, 0, n_samples)
    hard_case("sums over modes whose losses differ widely", far, 0, 1e-13, against="matrix product", floor=1)


@pytest.mark.parametrize("quantity", ["displacement", "velocity", "acceleration"])
@pytest.mark.parametrize("n_samples", [SHORTEST, 129, 1000, 1001, 4097])
def test_modal_sum_matches_matrix_product(quantity, n_samples, rng):
    modes = oscillators()
    weights = rng.normal(size=(37, 200)) * modes.omega_rad_per_s
    assert error(modes, weights, 0, n_samples, quantity) < 3e-14


@given(
    seed=st.integers(0, 2**32 - 1),
    start=st.integers(0, 50_000),
    n_samples=st.integers(1, 3000),
    n_modes=st.integers(1, 300),
    tau_s=st.floats(1e-6, 10.0) | st.just(np.inf),
)
@settings(max_examples=60, deadline=None)
def test_modal_sum_matches_matrix_product_for_any_input(seed, start, n_samples, n_modes, tau_s):
    rng = np.random.default_rng(seed)
    omega = np.sort(rng.uniform(0, np.pi * RATE_HZ, n_modes))
    modes = Oscillators(omega, np.full(n_modes, 1 / tau_s))
    weights = rng.normal(size=(3, n_modes))
    expected = weights @ modes.impulse(RATE_HZ, start, start + n_samples)
    found = modal_sums(modes, weights, RATE_HZ, start, start + n_samples)
    off = np.abs(found - expected).max() / max(np.abs(expected).max(), 1e-300)
    hard_case("sums over any modes, tau of 1 us to none", off, 0, 1e-12, against="matrix product", floor=1)


def test_frequencies_at_zero_and_at_nyquist_fold_right(rng):
    modes = oscillators(f_low_hz=1e-3, f_high_hz=RATE_HZ / 2)
    far = error(modes, rng.normal(size=(3, 200)) * modes.omega_rad_per_s, 0, 500)
    hard_case("modes at 0 Hz and at Nyquist", far, 0, 1e-13, against="matrix product", floor=1)


def test_creeping_and_fast_modes_are_added_exactly(rng):
    decay = np.full(200, 300.0)
    decay[[0, 7, 50]] = 1e5, 1e9, 5e3
    modes = oscillators(decay_per_s=decay)
    far = error(modes, rng.normal(size=(3, 200)) * modes.omega_rad_per_s, 0, 700)
    hard_case("modes that creep", far, 0, 1e-13, against="matrix product", floor=1)


def test_small_sums_use_the_plain_product(monkeypatch, rng):
    def never(*arguments):
        raise AssertionError(arguments)

    monkeypatch.setattr(modal_sum, "_transform", never)
    modal_sums(oscillators(FEWEST_MODES - 1), rng.normal(size=(2, FEWEST_MODES - 1)), RATE_HZ, 0, 1000)
    modal_sums(oscillators(), rng.normal(size=(2, 200)), RATE_HZ, 0, SHORTEST - 1)


def test_modal_sum_writes_to_given_output(rng):
    modes, weights, out = oscillators(), rng.normal(size=(40, 200)), np.zeros((40, 600))
    modal_sums(modes, weights, RATE_HZ, 0, 400, out=out[:, 100:500])
    assert np.array_equal(out[:, 100:500], modal_sums(modes, weights, RATE_HZ, 0, 400))
    assert not out[:, :100].any()
    assert not out[:, 500:].any()


def test_modes_in_any_order_have_one_sum(rng):
    modes, weights, order = oscillators(), rng.normal(size=(3, 200)), rng.permutation(200)
    expected = modal_sums(modes, weights, RATE_HZ, 0, 700)
    np.testing.assert_array_equal(modal_sums(modes.of(order), weights[:, order], RATE_HZ, 0, 700), expected)


@pytest.mark.parametrize("away", [0.0, 1e-3, 0.3])
def test_the_kernel_is_a_bessel_function(away):
    grid, bins = modal_sum._Grid.of(1750), np.linspace(-8, 8, 401) + 1j * away
    expected = iv(0, grid.beta * np.sqrt(1 - (bins / 8) ** 2))
    np.testing.assert_allclose(grid.kernel(bins), expected, rtol=0, atol=2e-14 * np.abs(expected).max())


def test_turns_hold_twice_the_digits_of_a_double():
    mpmath = pytest.importorskip("mpmath")
    omega = np.array([1.0, 12345.678, 3.1e5])
    high, low = turns(omega, 1_000_003.0, 250e3)
    with mpmath.workprec(200):
        for w, h, rest in zip(omega, high, low, strict=True):
            exact = mpmath.mpf(float(w)) * 1_000_003 / 250_000 / (2 * mpmath.pi)
            off = float((mpmath.mpf(float(h)) + mpmath.mpf(float(rest)) - exact) / exact)
            hard_case("turns as a pair of doubles", off, 0, 1e-30, against="60 digits", floor=1)


def exact(omega: float, decay: float, time: mpf) -> tuple[float, float]:
    """Displacement and velocity in 60 digits."""
    mp.dps = 60
    w, a = mpf(omega), mpf(decay)
    if w == a:
        return float(exp(-a * time) * time), float(exp(-a * time) * (1 - a * time))
    if w > a:
        s = sqrt(w * w - a * a)
        return float(exp(-a * time) * sin(s * time) / s), float(
            exp(-a * time) * (mp_cos(s * time) - a * sin(s * time) / s)
        )
    s = sqrt(a * a - w * w)
    return float(exp(-a * time) * sinh(s * time) / s), float(exp(-a * time) * (cosh(s * time) - a * sinh(s * time) / s))


CASES = {
    "mid band": (1.5e5, 285.7),
    "Nyquist": (math.pi * RATE_HZ, 100.0),
    "no loss": (1.5e5, 0.0),
    "tau of 1 us": (1.5e5, 1e6),
    "tau of 1 ns": (1.5e5, 1e9),
    "critical": (1e4, 1e4),
    "just under critical": (1e4, 1e4 * (1 - 1e-12)),
    "just over critical": (1e4, 1e4 * (1 + 1e-12)),
    "slow": (1e-4, 0.0),
    "rigid body with loss": (0.0, 300.0),
    "rigid body without loss": (0.0, 0.0),
}


@pytest.mark.parametrize("case", CASES)
def test_impulse_response_is_exact(case):
    omega, decay = CASES[case]
    one = Oscillators(np.array([omega]), np.array([decay]))
    found = [one.impulse(RATE_HZ, 0, 1000, quantity)[0] for quantity in ("displacement", "velocity")]
    for sample in (0, 1, 7, 300, 999):
        expected = exact(omega, decay, mpf(sample) / mpf(RATE_HZ))
        swing = max(omega, decay, 1.0 / (1000 / RATE_HZ))
        size = math.exp(-min(decay, omega**2 / (2 * decay) if decay else 0) * sample / RATE_HZ * 0.5)
        hard_case(
            "impulse response of a mode: Nyquist, no loss, tau of 1 us and 1 ns, critical, slow, rigid",
            found[0][sample], expected[0], 1e-11, against="60 digits", floor=0.02 * size / swing + 1e-289,
        )  # fmt: skip
        hard_case(
            "velocity of a mode", found[1][sample], expected[1], 1e-11, against="60 digits", floor=0.2 * size + 1e-289
        )


def test_acceleration_obeys_the_equation_of_motion():
    modes = Oscillators(np.array([0.0, 1e3, 1e5, 1e4]), np.array([300.0, 5e3, 300.0, 1e4]))
    u, v, a = (modes.impulse(RATE_HZ, 0, 500, q) for q in ("displacement", "velocity", "acceleration"))
    rest = a + 2 * modes.decay_per_s[:, None] * v + modes.omega_rad_per_s[:, None] ** 2 * u
    hard_case("acceleration of a mode", np.abs(rest).max() / np.abs(a).max(), 0, 1e-10, against="motion", floor=1)


def test_one_million_samples_without_drift():
    """T of 10 s: 1e-12 with block-anchored phases, against 60 digits."""
    omega = np.array([1.2345678e5, 3.0e4 * math.pi, 2 * math.pi * 25e3])
    modes = Oscillators(omega, np.zeros(3))
    for start in (0, 250_000, 999_000):
        found = modes.impulse(RATE_HZ, start, start + 1000) * omega[:, None]
        for sample in (0, 499, 999):
            for i in range(3):
                expected = exact(omega[i], 0.0, mpf(start + sample) / mpf(RATE_HZ))[0] * omega[i]
                hard_case(
                    "a million samples without loss", found[i, sample], expected, 1e-12, against="60 digits", floor=1
                )


@given(st.floats(1.0, 1e6), st.integers(0, 10**7), st.floats(1e3, 2e6))
def test_unit_phasor_is_exact_at_any_phase(omega, sample, rate):
    mp.dps = 50
    phase = mpf(omega) * sample / mpf(rate)
    found = unit_phasor(np.array([omega]), np.array([float(sample)]), rate)[0]
    exact = [float(mp_cos(phase)), float(sin(phase))]
    hard_case("phase of up to 1e10 turns", [found.real, found.imag], exact, 1e-15, against="50 digits", floor=1)


def test_pieces_are_the_whole():
    modes = Oscillators(np.linspace(0, 2e5, 20), np.full(20, 300.0))
    whole = modes.impulse(RATE_HZ, 0, 3000)
    pieces = [modes.impulse(RATE_HZ, *span) for span in ((0, 1), (1, 700), (700, 2049), (2049, 3000))]
    assert np.concatenate(pieces, axis=1) == pytest.approx(whole, rel=1e-13, abs=1e-18)


@given(st.floats(0.0, 1e6), st.floats(0.0, 1e9))
def test_always_finite_and_starts_at_rest(omega, decay):
    modes = Oscillators(np.array([omega]), np.array([decay]))
    u, v = modes.impulse(RATE_HZ, 0, 50), modes.impulse(RATE_HZ, 0, 50, "velocity")
    assert np.isfinite(u).all()
    assert np.isfinite(v).all()
    assert abs(u[0, 0]) < 1e-18
    assert v[0, 0] == pytest.approx(1.0, abs=1e-12)


STEP_S = 1e-5
STEPS = {
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


@pytest.mark.parametrize("case", [name for name in STEPS if name != "tau of 1 ns"])
def test_one_step_is_exact(case):
    omega, decay = STEPS[case]
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
    omega, decay = STEPS["tau of 1 ns"]
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


def test_run_equals_its_weighted_single_steps():
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
