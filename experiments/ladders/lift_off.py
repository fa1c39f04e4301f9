"""A finger that the plate throws off and that comes back, against the rate at which its contact is looked at."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from tactometry.stimuli.time_reversal import A4_SCREEN, Attenuation, Fingertip, PointForce, Screen
from tactometry.stimuli.time_reversal.lift_off import one_sided_contact
from tactometry.stimuli.time_reversal.responses.responses import impulse_responses, values_at

from ..cost.problem import Problem, Real, Reference, Rung, over_largest

Event = Callable[[float, Real], float]

AT, TO_HZ, COARSEST_HZ, DURATION_S = (0.05, 0.04), 8e3, 50e3, 3e-3
SMALL = Screen(replace(A4_SCREEN, length_m=0.12, width_m=0.09), (PointForce(0.08, 0.03),), Attenuation(2e-3))
IMPULSE_N_S = 2e-2
FORCE_N = 0.5
FACTORS = (1, 2, 4, 8, 16, 32)
FINEST = 64


def problem() -> Problem:
    """A tap beside a finger of 0.5 N throws it off twice."""
    return Problem(
        "largest error of the displacement under a finger of 0.5 N that lifts off, over the largest, 3 ms",
        reference=Reference(
            "Runge-Kutta of order 8 from event to event", lambda: by_events(Fingertip(), FORCE_N, COARSEST_HZ)[0], 1e-8
        ),
        independent=Reference("contact looked at 3.2 million times a second", lambda: _displacement_m(FINEST), 3e-6),
        error=over_largest,
        rungs=tuple(Rung(f"{COARSEST_HZ * k / 1e3:g} kHz", partial(_displacement_m, k)) for k in FACTORS),
    )


def free_m(rate_hz: float, impulse_n_s: float = IMPULSE_N_S) -> Real:
    """(n_samples,): the displacement of the free plate after a tap."""
    heard = impulse_responses(SMALL, [AT], rate_hz=rate_hz, duration_s=DURATION_S, f_max_hz=TO_HZ)
    return np.asarray(heard.samples[0, 0] * rate_hz * impulse_n_s)


def _displacement_m(factor: int) -> Real:
    rate_hz = COARSEST_HZ * factor
    found = one_sided_contact(SMALL, AT, free_m(rate_hz), rate_hz, TO_HZ, FORCE_N)
    return np.asarray(found.displacement_m[::factor])


def by_events(finger: Fingertip, force_n: float, rate_hz: float) -> tuple[Real, Real, int]:
    """Plate, skin and number of events: modes and skin as one system that changes where contact is lost or made."""
    from scipy.integrate import solve_ivp

    t = np.arange(round(DURATION_S * rate_hz)) / rate_hz
    modes, here = SMALL.oscillators(TO_HZ), values_at(SMALL, [AT], TO_HZ)[:, 0]
    slope, pressed_n, apart_m = _equations(finger, force_n)
    n, struck = modes.n, SMALL.modal_forces(TO_HZ)[:, 0] * IMPULSE_N_S / SMALL.plate.mass_kg
    state, now, together, n_events = np.concatenate([np.zeros(n), struck, [0.0]]), 0.0, True, 0
    plate, skin = np.zeros(t.size), np.zeros(t.size)
    while now < t[-1]:
        together = together and pressed_n(now, state) >= 0  # else the plate falls away faster than the skin
        event = pressed_n if together else apart_m
        run = solve_ivp(
            partial(slope, together=together), (now, t[-1]), state, "DOP853", events=event, dense_output=True,
            rtol=1e-9, atol=1e-15,
        )  # fmt: skip
        during = (t >= now) & (t <= run.t[-1])
        states = run.sol(t[during])  # type: ignore[misc] # asked for by dense_output
        plate[during], skin[during] = here @ states[:n], states[-1]
        now, state, hit = run.t[-1], run.y[:, -1], run.status == 1
        n_events, together = n_events + hit, together != hit
    return plate, skin, n_events


def _equations(finger: Fingertip, force_n: float) -> tuple[Callable[..., Real], Event, Event]:
    """Slope of the state (modes, their speeds, skin), force of a closed contact, gap of an open one."""
    modes, here, mass_kg = SMALL.oscillators(TO_HZ), values_at(SMALL, [AT], TO_HZ)[:, 0], SMALL.plate.mass_kg
    load, n = finger.load(AT, force_n), modes.n
    resistance, stiffness = load.resistance_n_s_per_m, load.stiffness_n_per_m

    def pressed_n(_: float, state: Real) -> float:
        return float(force_n + resistance * (here @ state[n:-1]) + stiffness * (here @ state[:n]))

    def apart_m(_: float, state: Real) -> float:
        return float(state[-1] - here @ state[:n])

    def slope(t_s: float, state: Real, *, together: bool) -> Real:
        answer_n = pressed_n(t_s, state) - force_n if together else -force_n
        restoring = -2 * modes.decay_per_s * state[n:-1] - modes.omega_rad_per_s**2 * state[:n]
        sinking = here @ state[n:-1] if together else -(force_n + stiffness * state[-1]) / resistance
        return np.concatenate([state[n:-1], restoring - here * answer_n / mass_kg, [sinking]])

    for event in (pressed_n, apart_m):
        event.terminal, event.direction = True, -1  # type: ignore[attr-defined] # as solve_ivp reads them
    return slope, pressed_n, apart_m
