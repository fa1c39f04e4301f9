"""Lift-off of a finger in a scene, against the linear contact."""

from dataclasses import replace

import numpy as np
import pytest
from scene_cases import effect, screen
from scene_errors import LOSSY, run

from tactometry.stimuli.composition.effect import FingerContact
from tactometry.stimuli.time_reversal.fingertip import Fingertip
from tactometry.stimuli.time_reversal.lift_off import one_sided_contacts
from tactometry.stimuli.time_reversal.responses.load import loaded_responses
from tactometry.stimuli.time_reversal.responses.responses import impulse_responses
from tactometry.stimuli.time_reversal.screen.attenuation import Attenuation
from tactometry.stimuli.time_reversal.screen.screen import Screen
from tactometry.stimuli.time_reversal.screen.transducer import PointForce

DRIVE = (LOSSY, effect("patches", side_m=8e-3), effect("one_bit"))
COURSES = ("t_s", "focus_displacement_m", "contact_displacement_m", "contact_force_n")
LIGHT = (FingerContact(0.05),)
"""Without contact for 1 % of the time."""


def touched(*more, contacts=LIGHT, outputs=(*COURSES, "contact_lost_s"), accuracy=1e-2):
    return replace(screen(*DRIVE, effect("finger_load"), *more, outputs=outputs, accuracy=accuracy), contacts=contacts)


def test_finger_in_contact_matches_linear_contact():
    firm = (FingerContact(2.0),)
    opened, linear = (
        run(replace(touched(*more, contacts=firm, outputs=COURSES), settings={"sampling": {"factor": 8}}))
        for more in ((effect("lift_off"),), ())
    )
    for name in COURSES:
        assert opened[name] == pytest.approx(linear[name], abs=1e-2 * np.abs(linear[name]).max())
    assert run(touched(effect("lift_off"), contacts=firm, outputs=("contact_lost_s",)))["contact_lost_s"] == 0


def test_lift_off_limits_pull_to_static_force():
    opened, linear = run(touched(effect("lift_off"))), run(touched(outputs=COURSES))
    assert linear["contact_force_n"].min() < -0.06
    assert opened["contact_force_n"].min() == pytest.approx(-0.05, rel=1e-12)
    assert opened["contact_lost_s"] > 0


def test_lift_off_error_is_within_predicted_error():
    for force_n in (0.05, 2.0):
        scene = touched(effect("lift_off"), contacts=(FingerContact(force_n),), outputs=COURSES[:3], accuracy=3e-3)
        plan = scene.resolve()
        (stage,) = (stage for stage in plan.stages if stage.name == "lift_off")
        finest = replace(scene, settings={"lift_off": {"finer": 16 * stage.settings["finer"]}})
        got, true = plan.run({"voltage_v": 30.0}), run(finest)
        for name in COURSES[1:3]:
            assert np.abs(got[name] - true[name]).max() <= stage.error * np.abs(true[name]).max()


def test_two_fingers_in_contact_match_linear_loads():
    whole = screen(*DRIVE).surface.plate
    places, rate_hz, band = [(0.05, 0.04), (0.09, 0.06)], 400e3, 8e3
    sampling = {"rate_hz": rate_hz, "duration_s": 3e-3, "f_max_hz": band}
    struck = Screen(whole, (PointForce(0.08, 0.03),), Attenuation(2e-3))
    loads = [Fingertip().load(place, 2.0) for place in places]
    free_m = impulse_responses(struck, places, **sampling).samples[:, 0]
    expected = loaded_responses(struck, places, loads, **sampling).samples[:, 0]
    found = one_sided_contacts(struck, free_m, loads, np.array([2.0, 2.0]), rate_hz, band)
    assert not found.apart.any()
    assert found.displacement_m == pytest.approx(expected, abs=5e-3 * np.abs(expected).max())


def test_light_finger_lifts_off_next_to_firm_finger():
    contacts = (FingerContact(0.05), FingerContact(2.0, x_m=0.09, y_m=0.06))
    got = run(touched(effect("lift_off"), contacts=contacts))
    light_s, firm_s = got["contact_lost_s"]
    assert light_s > 0 == firm_s


def test_no_voltage_throws_nothing_off():
    got = touched(effect("lift_off")).resolve().run({"voltage_v": 0.0})
    assert not any(np.any(got[name]) for name in (*COURSES[1:], "contact_lost_s"))
