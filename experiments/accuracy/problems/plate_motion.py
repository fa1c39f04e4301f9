"""Accuracy problems of plate motion, with and without a finger."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactometry.stimuli.time_reversal import Fingertip, Screen
from tactometry.stimuli.time_reversal.lift_off import one_sided_contact
from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN
from tactometry.stimuli.time_reversal.plate.oscillators import Oscillators
from tactometry.stimuli.time_reversal.plate.propagator import run_linear
from tactometry.stimuli.time_reversal.responses.load import PlateLoad, loaded_responses
from tactometry.stimuli.time_reversal.responses.responses import impulse_responses, values_at
from tactometry.stimuli.time_reversal.screen.attenuation import Attenuation
from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE
from tactometry.stimuli.time_reversal.screen.transducer import PointForce

from ..measure import Problem, Real, Reference, Setting, over_largest

FACTORS = (1, 4, 16, 64)
TONE_TO_HZ, TONE_RATE_HZ, TONE_LASTS_S, OMEGA_RAD_PER_S = 10e3, 40e3, 5e-3, 2 * np.pi * 4e3
LOADED_TO_HZ, LOADED_RATE_HZ, LOADED_LASTS_S = 4e3, 8e3, 4e-3
HEARD_M, PRESSED_M = (0.121, 0.093), (0.1, 0.1)
LOADED = Screen(A4_SCREEN, (PointForce(0.03, 0.02), PointForce(0.25, 0.19)), Attenuation(3.5e-3))
AT_M, TO_HZ, RATE_HZ, DURATION_S = (0.05, 0.04), 8e3, 50e3, 3e-3
SMALL = Screen(replace(A4_SCREEN, length_m=0.12, width_m=0.09), (PointForce(0.08, 0.03),), Attenuation(2e-3))
IMPULSE_N_S, FORCE_N = 2e-2, 0.5
LIFT_OFF_FACTORS = (1, 2, 4, 8, 16, 32)
Event = Callable[[float, Real], float]


def time_integration() -> Problem:
    """Compare time-stepped modes with exact matrix exponentials."""
    modes = A4_PROTOTYPE.oscillators(TONE_TO_HZ)
    return Problem(
        f"largest error of {modes.n} modal displacements over the largest, tone of 4 kHz from rest, 5 ms",
        reference=Reference("powers of the matrix exponential of mode and tone", lambda: _mode_powers(modes), 1e-10),
        error=over_largest,
        settings=_by_rate(TONE_RATE_HZ, FACTORS, partial(_propagation, modes)),
    )


def _by_rate(rate_hz: float, factors: tuple[int, ...], run: Callable[[int], Real]) -> tuple[Setting, ...]:
    return tuple(Setting(f"{rate_hz * factor / 1e3:g} kHz", partial(run, factor)) for factor in factors)


def times_s(factor: int) -> Real:
    """Return the tone's sample times (s) at `factor` times `TONE_RATE_HZ`."""
    return np.arange(round(TONE_LASTS_S * TONE_RATE_HZ) * factor + 1) / (TONE_RATE_HZ * factor)


def _propagation(modes: Oscillators, factor: int) -> Real:
    forces = np.broadcast_to(np.sin(OMEGA_RAD_PER_S * times_s(factor)), (modes.n, len(times_s(factor))))
    return run_linear(modes, forces, TONE_RATE_HZ * factor)[:, ::factor]


def _mode_powers(modes: Oscillators) -> Real:
    from scipy.linalg import expm

    tone, systems = OMEGA_RAD_PER_S, []
    for w, a in zip(modes.omega_rad_per_s, modes.decay_per_s, strict=True):
        systems.append([[0, 1, 0, 0], [-w * w, -2 * a, 1, 0], [0, 0, 0, tone], [0, 0, -tone, 0]])
    start = np.tile([0.0, 0.0, 0.0, 1.0], (modes.n, 1))
    return _powers(expm(np.array(systems) / TONE_RATE_HZ), start[..., None], len(times_s(1)))[:, :, 0, 0].T


def _powers(step: Real, start: Real, n: int) -> Real:
    """Return the states (n, ...) of a linear system after 0 to n - 1 steps."""
    states = [start]
    while len(states) < n:
        states.append(step @ states[-1])
    return np.array(states)


def finger_load() -> Problem:
    """Compare responses under a 2 N finger with those of coupled modes."""
    load = Fingertip(mass_kg=1e-4, stiffness_n_per_m=1e3).load(PRESSED_M, 2.0)
    return Problem(
        "largest error of the responses under a 2 N finger over the largest, modes below 4 kHz, 4 ms",
        reference=Reference("matrix exponential of all coupled modes", lambda: _coupled_modes(load), 1e-9),
        error=over_largest,
        settings=_by_rate(LOADED_RATE_HZ, FACTORS, partial(_loaded_response, load)),
    )


def _loaded_response(load: PlateLoad, factor: int) -> Real:
    timing = {"rate_hz": LOADED_RATE_HZ * factor, "duration_s": LOADED_LASTS_S, "f_max_hz": LOADED_TO_HZ}
    result = loaded_responses(LOADED, [HEARD_M], [load], **timing)
    return np.asarray(result.samples[0][:, ::factor] * timing["rate_hz"])


def _coupled_modes(load: PlateLoad) -> Real:
    from scipy.linalg import expm

    modes, mass_kg = LOADED.oscillators(LOADED_TO_HZ), LOADED.plate.mass_kg
    at, observed = (values_at(LOADED, [place], LOADED_TO_HZ)[:, 0] for place in (PRESSED_M, HEARD_M))
    coupled = np.outer(at, at) / mass_kg
    inertia = np.eye(modes.n) + load.mass_kg * coupled
    stiffness = np.diag(modes.omega_rad_per_s**2) + load.stiffness_n_per_m * coupled
    damping = np.diag(2 * modes.decay_per_s) + load.resistance_n_s_per_m * coupled
    upper = np.hstack([np.zeros_like(inertia), np.eye(modes.n)])
    step = expm(np.vstack([upper, -np.linalg.solve(inertia, np.hstack([stiffness, damping]))]) / LOADED_RATE_HZ)
    struck = np.linalg.solve(inertia, LOADED.modal_forces(LOADED_TO_HZ) / mass_kg)
    states = _powers(step, np.vstack([np.zeros_like(struck), struck]), round(LOADED_LASTS_S * LOADED_RATE_HZ))
    return np.asarray((observed @ states[:, : modes.n]).T)


def lift_off() -> Problem:
    """Compare contact checked at sample times with exact contact events."""
    return Problem(
        "largest error of the displacement under a 0.5 N finger that lifts off, over the largest, 3 ms",
        reference=Reference(
            "Runge-Kutta method of order 8 between contact events",
            lambda: by_events(Fingertip(), FORCE_N, RATE_HZ)[0],
            1e-8,
        ),
        error=over_largest,
        settings=_by_rate(RATE_HZ, LIFT_OFF_FACTORS, _displacement_m),
    )


def free_m(rate_hz: float, impulse_n_s: float = IMPULSE_N_S) -> Real:
    """Return the displacement (n_samples,) of the free plate after a tap."""
    responses = impulse_responses(SMALL, [AT_M], rate_hz=rate_hz, duration_s=DURATION_S, f_max_hz=TO_HZ)
    return np.asarray(responses.samples[0, 0] * rate_hz * impulse_n_s)


def _displacement_m(factor: int) -> Real:
    rate_hz = RATE_HZ * factor
    result = one_sided_contact(SMALL, AT_M, free_m(rate_hz), rate_hz, TO_HZ, FORCE_N)
    return np.asarray(result.displacement_m[::factor])


def by_events(finger: Fingertip, force_n: float, rate_hz: float) -> tuple[Real, Real, int]:
    """Integrate modes and skin as one system with contact events.

    Returns the displacements of plate and skin, and the number of contact events.
    """
    from scipy.integrate import solve_ivp

    t = np.arange(round(DURATION_S * rate_hz)) / rate_hz
    modes, here = SMALL.oscillators(TO_HZ), values_at(SMALL, [AT_M], TO_HZ)[:, 0]
    slope, pressed_n, apart_m = _equations(modes, here, finger, force_n)
    struck = SMALL.modal_forces(TO_HZ)[:, 0] * IMPULSE_N_S / SMALL.plate.mass_kg
    state, now, together, n_events = np.concatenate([np.zeros(modes.n), struck, [0.0]]), 0.0, True, 0
    plate, skin = np.zeros(t.size), np.zeros(t.size)
    options: dict[str, Any] = {"method": "DOP853", "dense_output": True, "rtol": 1e-9, "atol": 1e-15}
    while now < t[-1]:
        together = together and pressed_n(now, state) >= 0  # else the plate recedes faster than the skin
        event = pressed_n if together else apart_m
        run = solve_ivp(partial(slope, together=together), (now, t[-1]), state, events=event, **options)
        during = (t >= now) & (t <= run.t[-1])
        states = run.sol(t[during])  # type: ignore[misc] # given with dense_output
        plate[during], skin[during] = here @ states[: modes.n], states[-1]
        now, state, hit = run.t[-1], run.y[:, -1], run.status == 1
        n_events, together = n_events + hit, together != hit
    return plate, skin, n_events


def _equations(
    modes: Oscillators, here: NDArray[np.float64], finger: Fingertip, force_n: float
) -> tuple[Callable[..., Real], Event, Event]:
    """Return the derivative of modes, speeds and skin, and the event functions."""
    load, n = finger.load(AT_M, force_n), modes.n
    resistance, stiffness = load.resistance_n_s_per_m, load.stiffness_n_per_m

    def pressed_n(_: float, state: Real) -> float:
        return float(force_n + resistance * (here @ state[n:-1]) + stiffness * (here @ state[:n]))

    def apart_m(_: float, state: Real) -> float:
        return float(state[-1] - here @ state[:n])

    def slope(t_s: float, state: Real, *, together: bool) -> Real:
        answer_n = pressed_n(t_s, state) - force_n if together else -force_n
        restoring = -2 * modes.decay_per_s * state[n:-1] - modes.omega_rad_per_s**2 * state[:n]
        sinking = here @ state[n:-1] if together else -(force_n + stiffness * state[-1]) / resistance
        return np.concatenate([state[n:-1], restoring - here * answer_n / SMALL.plate.mass_kg, [sinking]])

    for event in (pressed_n, apart_m):
        event.terminal, event.direction = True, -1  # type: ignore[attr-defined] # read by solve_ivp
    return slope, pressed_n, apart_m
