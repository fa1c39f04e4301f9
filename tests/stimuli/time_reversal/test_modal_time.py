"""The oscillators in time: exact in every case of damping, and without drift."""

import math

import numpy as np
import pytest
from hard_cases import hard_case
from hypothesis import given, strategies as st
from mpmath import cos as mp_cos, cosh, exp, mp, mpf, sin, sinh, sqrt

from tactometry.stimuli.time_reversal.plate.oscillators import Oscillators, unit_phasor

RATE_HZ = 100e3


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
