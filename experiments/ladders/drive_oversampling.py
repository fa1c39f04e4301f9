"""What a one-bit drive makes of the focus, against the rate of its samples."""

from dataclasses import replace
from functools import partial

import numpy as np

from tactometry.stimuli.time_reversal import drive, impulse_responses
from tactometry.stimuli.time_reversal.plate.oscillators import Oscillators
from tactometry.stimuli.time_reversal.responses.responses import values_at
from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE, Screen

from ..cost.problem import Problem, Real, Reference, Rung, over_rms

F_MAX_HZ, DURATION_S = 10e3, 4e-3
FOCI_M = ((0.121, 0.093), (0.06, 0.15), (0.2, 0.05), (0.17, 0.13))
RATES_HZ = (25e3, 100e3, 400e3, 1.6e6)
SEARCH_HZ, FINE_HZ, N_NEWTON = 200e3, 12.8e6, 5


def problem() -> Problem:
    """What samples of the sign add up to at four foci, against a sign that changes at any time."""
    screen = replace(A4_PROTOTYPE, sources=A4_PROTOTYPE.sources[::8])
    return Problem(
        "rms error of the focus that a channel makes over the rms focus, one bit, modes below 10 kHz, 4 ms",
        reference=Reference("closed integrals between the zeros", lambda: _at_crossings(screen), 1e-8),
        independent=Reference("samples at 12.8 MHz", lambda: _emission(screen, FINE_HZ), 2e-5),
        error=over_rms,
        rungs=tuple(Rung(f"{rate_hz / 1e3:g} kHz", partial(_emission, screen, rate_hz)) for rate_hz in RATES_HZ),
    )


def _emission(screen: Screen, rate_hz: float) -> Real:
    """(n_foci, n_channels): what each channel's sign, sampled and emitted, does at the focus."""
    heard = impulse_responses(screen, FOCI_M, rate_hz=rate_hz, duration_s=DURATION_S, f_max_hz=F_MAX_HZ)
    drives = [drive(heard.at_point(n), 1.0).samples[:, ::-1] for n in range(heard.n_points)]
    return np.asarray(np.einsum("pqn,pqn->pq", np.array(drives), heard.samples))


def _at_crossings(screen: Screen) -> Real:
    """Integrals of |h| between its zeros, each found to rounding, from the integrals of the modes in closed form."""
    modes = screen.oscillators(F_MAX_HZ)
    forces = screen.modal_forces(F_MAX_HZ) / screen.plate.mass_kg
    shapes = values_at(screen, FOCI_M, F_MAX_HZ)
    return np.array([[_integral(modes, shape * force) for force in forces.T] for shape in shapes.T])


def _integral(modes: Oscillators, weights: Real) -> float:
    at_s = np.arange(1, round(DURATION_S * SEARCH_HZ) + 1) / SEARCH_HZ
    course = weights @ modes.impulse_at(at_s)
    zeros_s = at_s[:-1][course[:-1] * course[1:] < 0] + 0.5 / SEARCH_HZ
    for _ in range(N_NEWTON):
        slope = weights @ modes.impulse_at(zeros_s, "velocity")
        zeros_s = zeros_s - np.clip(weights @ modes.impulse_at(zeros_s) / slope, -0.5 / SEARCH_HZ, 0.5 / SEARCH_HZ)
    ends_s = np.concatenate([[0.0], zeros_s, [DURATION_S]])
    return float(np.abs(np.diff(weights @ _integrals(modes, ends_s))).sum())


def _integrals(modes: Oscillators, at_s: Real) -> Real:
    """(n_modes, n_times): integrals of the impulse responses from 0, by the equation of motion."""
    velocity, displacement = (modes.impulse_at(at_s, quantity) for quantity in ("velocity", "displacement"))
    moved = 1 - velocity - 2 * modes.decay_per_s[:, None] * displacement
    return np.asarray(moved / modes.omega_rad_per_s[:, None] ** 2)
