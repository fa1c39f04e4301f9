"""Foci at named places, one or several at once, and what each of some fingers feels of them."""

from dataclasses import replace
from math import inf

import numpy as np
import pytest
from felt_models import felt_by

from tactometry.contact import Contact
from tactometry.errors import InvalidParameter
from tactometry.experiments.study.felt_scene import felt
from tactometry.signal import Signal
from tactometry.stimuli.scenes.default_scenes import default_scene
from tactometry.stimuli.scenes.effects.finger_load import FingerLoad
from tactometry.stimuli.time_reversal import FocusTrain, Responses, Setup, TimeReversalSensation, impulse_responses
from tactometry.stimuli.time_reversal.fingertip import Fingertip
from tactometry.stimuli.time_reversal.focusing.focusing import emitted
from tactometry.stimuli.time_reversal.responses.load import loaded_responses
from tactometry.stimuli.time_reversal.stimulus.focus_train import measured
from tactometry.stimuli.time_reversal.stimulus.placed_foci import FingersSensation, Place, PlacedFoci
from tactometry.stimuli.time_reversal.stimulus.sensation import events, felt_amplitude_m

SETUP = Setup(n_transducers=8, modes_to_hz=11e3, rate_hz=25e3)
PLACES = {"index": Place(0.10), "middle": Place(0.12), "thumb": Place(0.11, 0.05)}
TOUCH = Contact(1.0)


def foci(place, **keys):
    return PlacedFoci(SETUP, f_max_hz=10e3, voltage_max_v=1e9, places=PLACES, place=place, **keys)


def felt_under(*fingers, places=PLACES):
    return felt(default_scene(FingersSensation(SETUP, places, fingers)))


def heard(at_m, signal):
    """The plate at a point, by plain convolution with the model's response there."""
    model = impulse_responses(
        SETUP.screen, [at_m], rate_hz=SETUP.rate_hz, duration_s=SETUP.heard_s, f_max_hz=SETUP.modes_to_hz
    )
    pairs = zip(signal.samples, model.samples[0], strict=True)
    return np.sum([np.convolve(drive, response) for drive, response in pairs], axis=0)


def test_one_place_is_the_focus_of_a_setup_there():
    there = FocusTrain(replace(SETUP, focus_x_m=0.12), f_max_hz=10e3, voltage_max_v=1e9)
    np.testing.assert_array_equal(foci("middle").at(20.0).samples, there.at(20.0).samples)


def test_foci_at_once_have_their_level_as_mean_amplitude():
    signal = foci("index + thumb").at(20.0)
    instant = signal.samples.shape[1] - 1
    amplitudes_m = [heard(at_m, signal)[instant] for at_m in ((0.10, 0.093), (0.11, 0.05))]
    assert np.mean(amplitudes_m) == pytest.approx(1e-5, rel=1e-9)
    assert min(amplitudes_m) > 0.5e-5  # two foci, not one and its tail


def test_each_finger_feels_the_field_of_all_foci_under_it():
    signal, skin = foci("index + thumb").at(26.0), felt_under()
    courses_m = [heard(place.on(SETUP), signal) for place in PLACES.values()]
    felt_m = [felt_amplitude_m(*events(course_m, SETUP.rate_hz)) for course_m in courses_m]
    np.testing.assert_allclose(skin.fingers_db(signal, TOUCH), 20 * np.log10(np.array(felt_m) / 10e-6), atol=1e-9)
    for name, course_m, felt_one_m in zip(PLACES, courses_m, felt_m, strict=True):
        if name in {"index", "thumb"}:  # beside a focus, what passes by counts too
            assert felt_one_m == pytest.approx(np.abs(course_m).max())
    assert skin.sensation_db(signal, TOUCH) == max(skin.fingers_db(signal, TOUCH))


def test_single_finger_sensation_matches_focus_sensation():
    signal, skin = foci("index").at(26.0), felt_under("middle")
    alone = felt_by(TimeReversalSensation(SETUP, finger_x_m=0.12))
    assert skin.fingers_db(signal, TOUCH) == (alone.sensation_db(signal, TOUCH),)


def test_loading_fingers_damp_sensation_of_others():
    """Beside the responses of the plate that bears all of them, each under its share of the force."""
    near = {"index": Place(0.10), "middle": Place(0.11)}
    signal = replace(foci("index"), places=near).at(20.0)
    loads = [Fingertip().load(place.on(SETUP), 0.75) for place in near.values()]
    sampling = {"rate_hz": SETUP.rate_hz, "duration_s": SETUP.heard_s, "f_max_hz": SETUP.modes_to_hz}
    scene = default_scene(FingersSensation(SETUP, near))
    found_db = replace(scene, effects=(FingerLoad(), *scene.effects)).fingers_db(signal, Contact(1.5))

    def felt_db(bearing):
        bears = loaded_responses(SETUP.screen, [place.on(SETUP) for place in near.values()], bearing, **sampling)
        felt_m = [felt_amplitude_m(*events(course, SETUP.rate_hz)) for course in emitted(signal, bears)]
        return 20 * np.log10(np.array(felt_m) / 10e-6)

    np.testing.assert_allclose(found_db, felt_db(loads), atol=2e-2)
    assert found_db[0] < felt_db(loads[:1])[0] - 0.05


def test_fingers_that_do_not_touch_feel_nothing():
    skin = felt_under()
    assert skin.fingers_db(foci("index").at(20.0), Contact(0.0)) == (-inf, -inf, -inf)
    silence = Signal(np.zeros((8, 3)), 25e3, "V")
    assert skin.sensation_db(silence, TOUCH) == -inf


def test_foci_use_responses_learnt_at_all_places():
    each = [SETUP.responses_at(*place.on(SETUP)).samples for place in PLACES.values()]
    learnt = Responses(np.concatenate(each), SETUP.rate_hz)
    for place in ("middle", "index + thumb"):
        found = measured(foci(place), learnt)
        np.testing.assert_array_equal(found.at(20.0).samples, foci(place).at(20.0).samples)
    with pytest.raises(InvalidParameter, match="found 1 points, expected 3, one for each of index, middle, thumb"):
        measured(foci("middle"), learnt.at_point(1))


def test_switched_supply_makes_simultaneous_foci():
    stimulus = foci("index + thumb", supply_v=400.0)
    signal = stimulus.at(20.0)
    assert set(np.unique(np.abs(signal.samples))) == {0.0, 400.0}
    instant = round(stimulus.emission_s * SETUP.rate_hz) - 1
    amplitudes_m = [heard(at_m, signal)[instant] for at_m in stimulus.places_made_m]
    assert np.mean(amplitudes_m) == pytest.approx(1e-5, rel=0.02)
