"""What a finger does to the responses of the plate, against the rate at which its correction is sampled."""

from functools import partial

import numpy as np

from tactometry.stimuli.time_reversal import Fingertip, PlateLoad, PointForce, Screen, loaded_responses
from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN
from tactometry.stimuli.time_reversal.responses.responses import values_at
from tactometry.stimuli.time_reversal.screen.attenuation import Attenuation

from ..cost.problem import Problem, Real, Reference, Rung, over_largest

F_MAX_HZ, COARSEST_HZ, DURATION_S = 4e3, 8e3, 4e-3
FACTORS = (1, 4, 16, 64)
FINEST = 512
HEARD_M, AT_M = (0.121, 0.093), (0.1, 0.1)
SCREEN = Screen(A4_SCREEN, (PointForce(0.03, 0.02), PointForce(0.25, 0.19)), Attenuation(3.5e-3))


def problem() -> Problem:
    """A finger of 2 N, 20 mm beside the place that is heard, at 8 000 times a second."""
    load = Fingertip(mass_kg=1e-4, stiffness_n_per_m=1e3).load(AT_M, 2.0)
    return Problem(
        "largest error of the responses under a finger of 2 N over the largest, modes below 4 kHz, 4 ms",
        reference=Reference("the exponential of all modes at once", lambda: _exponentials(load), 1e-9),
        independent=Reference("correction sampled at 4.1 MHz", lambda: _loaded_response(load, FINEST), 2e-5),
        error=over_largest,
        rungs=tuple(Rung(f"{COARSEST_HZ * k / 1e3:g} kHz", partial(_loaded_response, load, k)) for k in FACTORS),
    )


def _loaded_response(load: PlateLoad, factor: int) -> Real:
    rate_hz = COARSEST_HZ * factor
    found = loaded_responses(SCREEN, [HEARD_M], [load], rate_hz=rate_hz, duration_s=DURATION_S, f_max_hz=F_MAX_HZ)
    return np.asarray(found.samples[0][:, ::factor] * rate_hz)


def _exponentials(load: PlateLoad) -> Real:
    """Powers of the exponential of all modes at once, coupled by the finger."""
    from scipy.linalg import expm

    modes = SCREEN.oscillators(F_MAX_HZ)
    at, heard = (values_at(SCREEN, [place], F_MAX_HZ)[:, 0] for place in (AT_M, HEARD_M))
    plate_kg = SCREEN.plate.mass_kg
    coupled = np.outer(at, at) / plate_kg
    inertia = np.eye(modes.n) + load.mass_kg * coupled
    stiffness = np.diag(modes.omega_rad_per_s**2) + load.stiffness_n_per_m * coupled
    damping = np.diag(2 * modes.decay_per_s) + load.resistance_n_s_per_m * coupled
    upper = np.hstack([np.zeros_like(inertia), np.eye(modes.n)])
    step = expm(np.vstack([upper, -np.linalg.solve(inertia, np.hstack([stiffness, damping]))]) / COARSEST_HZ)
    struck = np.linalg.solve(inertia, SCREEN.modal_forces(F_MAX_HZ) / plate_kg)
    state, course = np.vstack([np.zeros_like(struck), struck]), []
    for _ in range(round(DURATION_S * COARSEST_HZ)):
        course.append(heard @ state[: modes.n])
        state = step @ state
    return np.array(course).T
