"""Lift-off from the plate, against equations of motion with events."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from tactometry.errors import InvalidParameter
from tactometry.experiments.accuracy.problems.plate_motion import (
    AT_M as AT,
    DURATION_S,
    IMPULSE_N_S,
    SMALL,
    TO_HZ,
    by_events,
    free_m,
)
from tactometry.stimuli.time_reversal.fingertip import Fingertip
from tactometry.stimuli.time_reversal.lift_off import one_sided_contact
from tactometry.stimuli.time_reversal.responses.load import loaded_responses

RATE_HZ = 400e3


@pytest.mark.parametrize("finger", [Fingertip(), Fingertip(stiffness_n_per_m=2e3)], ids=["damper", "damper and spring"])
def test_lift_off_matches_event_based_solution(finger):
    plate, skin, n_events = by_events(finger, 0.5, RATE_HZ)
    found = one_sided_contact(SMALL, AT, free_m(RATE_HZ), RATE_HZ, TO_HZ, 0.5, finger)
    assert n_events >= 3
    assert found.apart.any()
    largest = np.abs(plate).max()
    assert found.displacement_m == pytest.approx(plate, abs=2e-4 * largest)
    assert found.skin_m == pytest.approx(skin, abs=2e-4 * largest)


def test_hard_pressed_finger_matches_linear_contact():
    finger = replace(Fingertip(), exponent=0.0)
    found = one_sided_contact(SMALL, AT, free_m(RATE_HZ), RATE_HZ, TO_HZ, 1e3, finger)
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
            one_sided_contact(SMALL, AT, free_m(RATE_HZ), RATE_HZ, TO_HZ, 0.5, finger)
