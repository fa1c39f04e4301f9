"""Modes under a tone, stepped exactly with the force linear between samples, against the tone itself."""

from functools import partial

import numpy as np

from tactometry.stimuli.time_reversal.plate.oscillators import Oscillators
from tactometry.stimuli.time_reversal.plate.propagator import run_linear
from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE

from ..cost.problem import Problem, Real, Reference, Rung, over_largest

F_MAX_HZ, TONE_HZ, COARSEST_HZ, DURATION_S = 10e3, 4e3, 40e3, 5e-3
FACTORS = (1, 4, 16, 64)
OMEGA_RAD_PER_S = 2 * np.pi * TONE_HZ


def problem() -> Problem:
    """Displacements of the modes below 10 kHz at 40 000 times a second, relative to the largest."""
    modes = A4_PROTOTYPE.oscillators(F_MAX_HZ)
    return Problem(
        f"largest error of {modes.n} modal displacements over the largest, tone of 4 kHz from rest, 5 ms",
        reference=Reference("the response of a mode in closed form", lambda: closed_form(modes), 1e-11),
        independent=Reference("powers of the exponential of mode and tone", lambda: _exponentials(modes), 1e-10),
        error=over_largest,
        rungs=tuple(Rung(f"{COARSEST_HZ * k / 1e3:g} kHz", partial(_propagation, modes, k)) for k in FACTORS),
    )


def times_s(factor: int) -> Real:
    return np.arange(round(DURATION_S * COARSEST_HZ) * factor + 1) / (COARSEST_HZ * factor)


def _propagation(modes: Oscillators, factor: int) -> Real:
    forces = np.broadcast_to(np.sin(OMEGA_RAD_PER_S * times_s(factor)), (modes.n, len(times_s(factor))))
    return run_linear(modes, forces, COARSEST_HZ * factor)[:, ::factor]


def closed_form(modes: Oscillators) -> Real:
    """(n_modes, n_times): the steady tone less the free motion that starts it from rest."""
    a, omega2 = modes.decay_per_s, modes.omega_rad_per_s**2
    steady = 1 / (omega2 - OMEGA_RAD_PER_S**2 + 2j * a * OMEGA_RAD_PER_S)
    g, slope = (modes.impulse_at(times_s(1), quantity) for quantity in ("displacement", "velocity"))
    start, speed = steady.imag[:, None], OMEGA_RAD_PER_S * steady.real[:, None]
    tone = np.exp(1j * OMEGA_RAD_PER_S * times_s(1))
    return np.asarray((steady[:, None] * tone).imag - start * (slope + 2 * a[:, None] * g) - speed * g)


def _exponentials(modes: Oscillators) -> Real:
    """Powers of the exponential of each mode together with the tone that drives it."""
    from scipy.linalg import expm

    states = np.zeros((len(times_s(1)), modes.n, 4))
    states[0, :, 3] = 1.0
    step = np.array(
        [expm(_system(*mode) / COARSEST_HZ) for mode in zip(modes.omega_rad_per_s, modes.decay_per_s, strict=True)]
    )
    for k in range(1, len(states)):
        states[k] = np.einsum("nij,nj->ni", step, states[k - 1])
    return np.asarray(states[:, :, 0].T)


def _system(omega_rad_per_s: float, decay_per_s: float) -> Real:
    w, a, tone = omega_rad_per_s, decay_per_s, OMEGA_RAD_PER_S
    return np.array([[0, 1, 0, 0], [-w * w, -2 * a, 1, 0], [0, 0, 0, tone], [0, 0, -tone, 0]])
