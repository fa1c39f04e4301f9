"""A finger that the plate throws off, beside its equations of motion with events."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.integrate import solve_ivp

from tactometry.errors import InvalidParameter
from tactometry.stimuli.time_reversal.finger import Fingertip
from tactometry.stimuli.time_reversal.lift_off import one_sided_contact
from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN
from tactometry.stimuli.time_reversal.responses.load import loaded_responses
from tactometry.stimuli.time_reversal.responses.responses import impulse_responses, values_at
from tactometry.stimuli.time_reversal.screen.attenuation import Attenuation
from tactometry.stimuli.time_reversal.screen.screen import Screen
from tactometry.stimuli.time_reversal.screen.transducer import PointForce

AT, TO_HZ, RATE_HZ, DURATION_S = (0.05, 0.04), 8e3, 400e3, 3e-3
SMALL = Screen(replace(A4_SCREEN, length_m=0.12, width_m=0.09), (PointForce(0.08, 0.03),), Attenuation(2e-3))
IMPULSE_N_S = 2e-2


def free_m(rate_hz=RATE_HZ, impulse_n_s=IMPULSE_N_S):
    sampling = {"rate_hz": rate_hz, "duration_s": DURATION_S, "f_max_hz": TO_HZ}
    return impulse_responses(SMALL, [AT], **sampling).samples[0, 0] * rate_hz * impulse_n_s


def by_events(finger, force_n):
    """Plate, skin and number of events: modes and skin, integrated from event to event by Runge-Kutta of order 8."""
    modes, mass_kg = SMALL.oscillators(TO_HZ), SMALL.plate.mass_kg
    n, here = modes.n, values_at(SMALL, [AT], TO_HZ)[:, 0]
    load = finger.load(AT, force_n)
    resistance, stiffness = load.resistance_n_s_per_m, load.stiffness_n_per_m

    def answer(state, together):
        return resistance * (here @ state[n:-1]) + stiffness * (here @ state[:n]) if together else -force_n

    def slope(_, state, together):
        f = answer(state, together)
        own = -2 * modes.decay_per_s * state[n:-1] - modes.omega_rad_per_s**2 * state[:n]
        sinking = here @ state[n:-1] if together else -(force_n + stiffness * state[-1]) / resistance
        return np.concatenate([state[n:-1], own - here * f / mass_kg, [sinking]])

    def lifts(_, state, together):
        return force_n + answer(state, True) if together else 1.0

    def meets(_, state, together):
        return 1.0 if together else state[-1] - here @ state[:n]

    lifts.terminal = meets.terminal = True
    lifts.direction = meets.direction = -1
    t = np.arange(round(DURATION_S * RATE_HZ)) / RATE_HZ
    state = np.concatenate([np.zeros(n), SMALL.modal_forces(TO_HZ)[:, 0] * IMPULSE_N_S / mass_kg, [0.0]])
    now, together, n_events, plate, skin = 0.0, True, 0, np.zeros(t.size), np.zeros(t.size)
    while now < t[-1]:
        together = together and force_n + answer(state, True) >= 0  # else the plate falls away faster than the skin
        run = solve_ivp(
            slope, (now, t[-1]), state, "DOP853", args=(together,), events=(lifts, meets), dense_output=True,
            rtol=1e-9, atol=1e-15,
        )  # fmt: skip
        during = (t >= now) & (t <= run.t[-1])
        states = run.sol(t[during])
        plate[during], skin[during] = here @ states[:n], states[-1]
        now, state = run.t[-1], run.y[:, -1]
        n_events += run.status == 1
        together = together != (run.status == 1)
    return plate, skin, n_events


@pytest.mark.parametrize("finger", [Fingertip(), Fingertip(stiffness_n_per_m=2e3)], ids=["damper", "damper and spring"])
def test_a_finger_that_lifts_off_is_that_of_its_events(finger):
    plate, skin, n_events = by_events(finger, 0.5)
    found = one_sided_contact(SMALL, AT, free_m(), RATE_HZ, TO_HZ, 0.5, finger)
    assert n_events >= 3
    assert found.apart.any()
    largest = np.abs(plate).max()
    assert found.displacement_m == pytest.approx(plate, abs=2e-4 * largest)
    assert found.skin_m == pytest.approx(skin, abs=2e-4 * largest)


def test_a_finger_that_is_pressed_hard_is_the_linear_one():
    finger = replace(Fingertip(), exponent=0.0)
    found = one_sided_contact(SMALL, AT, free_m(), RATE_HZ, TO_HZ, 1e3, finger)
    sampling = {"rate_hz": RATE_HZ, "duration_s": DURATION_S, "f_max_hz": TO_HZ}
    linear = loaded_responses(SMALL, [AT], [finger.load(AT, 1e3)], **sampling).samples[0, 0] * RATE_HZ * IMPULSE_N_S
    assert not found.apart.any()
    assert found.displacement_m == pytest.approx(linear, abs=5e-3 * np.abs(linear).max())


@given(
    force_n=st.floats(0.01, 20.0),
    impulse_n_s=st.floats(1e-4, 1.0),
    stiffness_n_per_m=st.one_of(st.just(0.0), st.floats(1.0, 1e4)),
)
@settings(max_examples=20, deadline=None)
def test_a_finger_never_pulls_and_is_never_inside_of_the_plate(force_n, impulse_n_s, stiffness_n_per_m):
    finger = Fingertip(stiffness_n_per_m=stiffness_n_per_m)
    course = free_m(100e3, impulse_n_s)
    found = one_sided_contact(SMALL, AT, course, 100e3, TO_HZ, force_n, finger)
    gap_m, largest = found.skin_m - found.displacement_m, np.abs(course).max()
    assert found.contact_force_n.min() >= 0
    assert gap_m.min() >= -1e-12 * largest
    assert np.abs(gap_m[~found.apart]).max() <= 1e-12 * largest


def test_a_finger_with_a_mass_or_without_resistance_is_refused():
    for finger in (Fingertip(mass_kg=1e-4), Fingertip(0.0, stiffness_n_per_m=1e3)):
        with pytest.raises(InvalidParameter, match=r"one_sided_contact.finger: found a mass of"):
            one_sided_contact(SMALL, AT, free_m(), RATE_HZ, TO_HZ, 0.5, finger)
