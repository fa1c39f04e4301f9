"""Refusals of contradictory, invalid or too costly scenes."""

from dataclasses import replace

import pytest
from scene_cases import effect, screen, small_screen
from scene_errors import LOSSY, run

from tactometry.errors import InvalidParameter
from tactometry.stimuli.composition.effect import FingerContact
from tactometry.stimuli.scenes.scene import Scene
from tactometry.stimuli.scenes.surfaces.time_reversal import TimeReversal


def test_too_costly_accuracy_is_refused_with_reason():
    large = Scene(TimeReversal(), (LOSSY,), ("field_m",), 5e-5)
    with pytest.raises(InvalidParameter, match=r"field_m: .*for a grid, which takes .* points, .*loosen"):
        large.resolve()
    long = Scene(small_screen(reversal_s=30.0), (), ("peak_m",), 1e-3)
    with pytest.raises(InvalidParameter, match=r"accuracy: .*for the modes, which takes .* numbers, .*reversal_s"):
        long.resolve()
    free = screen(effect("edges", boundary="FFFF"), LOSSY, accuracy=1e-7)
    with pytest.raises(InvalidParameter, match=r"accuracy: .*edges are not simply supported.*remove 'edges'"):
        replace(free, surface=TimeReversal(reversal_s=1e-3)).resolve()


@pytest.mark.parametrize(
    ("effects", "message"),
    [
        (lambda: [effect("one_bit"), effect("sigma_delta")],
         r"'sigma_delta' with 'one_bit', .*in the slot quantiser; remove"),
        (lambda: [LOSSY, LOSSY], r"'attenuation' with 'attenuation', expected only one of them"),
        (lambda: [effect("airborne_sound")], r"'airborne_sound' without an effect in slot attenuation, .*add it or"),
        (lambda: [effect("shear"), effect("finger_load")],
         r"'finger_load' with 'shear', expected only one of them: .*remove 'shear' or 'finger_load'"),
        (lambda: [effect("friction")], r"'friction', which 'time_reversal' does not support"),
    ],
)  # fmt: skip
def test_contradictory_effects_are_refused_with_fix(effects, message):
    with pytest.raises(InvalidParameter, match=message):
        screen(*effects())


def test_finger_load_without_contact_is_refused():
    with pytest.raises(InvalidParameter, match=r"'finger_load' without a resting contact, .*\[\[contacts\]\]"):
        Scene(small_screen(), (effect("finger_load"),), ("peak_m",))
    with pytest.raises(InvalidParameter, match=r"'finger_load' without a resting contact, .*no speed"):
        Scene(small_screen(), (effect("finger_load"),), ("peak_m",), contacts=(FingerContact(1.0, 0.05),))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"glass": "Borofloat"}, r"TimeReversal\.glass: .*did you mean 'Borofloat 33'"),
        ({"focus_x_m": 0.2}, r"TimeReversal\.focus_x_m: found 0\.2, expected a place between the edges"),
        ({"f_max_hz": 40e3}, r"TimeReversal\.f_max_hz: .*half of rate_hz, 30000\.0; lower it or raise"),
        ({"flank_hz": 20e3}, r"TimeReversal\.flank_hz: .*at most f_max_hz"),
        ({"inset_m": 0.05}, r"TimeReversal\.inset_m: .*half of the shorter side"),
        ({"n_transducers": 0}, r"TimeReversal\.n_transducers: found 0, expected a whole number, at least 1"),
        ({"thickness_m": float("nan")}, r"TimeReversal\.thickness_m: found nan"),
    ],
)
def test_a_screen_outside_of_its_domain_is_refused(changes, message):
    with pytest.raises(InvalidParameter, match=message):
        small_screen(**changes)


@pytest.mark.parametrize(
    ("kind", "values", "message"),
    [
        ("edges", {"boundary": "SSSS"}, r"remove the effect"),
        ("edges", {"boundary": "SSXF"}, r"expected four letters of S, C, F"),
        (
            "temperature_drift",
            {"kelvin": 3e4},
            r"shift_of_frequencies: found -1\.5, expected a number from -0\.1 to 0\.1",
        ),
        ("temperature_drift", {"kelvin": 0.0}, r"omit the effect if there is no drift"),
        ("foci", {"x_m": (0.1,), "y_m": ()}, r"expected equal numbers"),
        ("sigma_delta", {"order": 3}, r"expected 1 or 2"),
        ("repetition", {"envelope": "sync"}, r"did you mean 'sinc'"),
        ("finger_load", {"resistance_n_s_per_m": 0.0}, r"expected a finite number above 0"),
        ("attenuation", {"tau_s": 0.0}, r"Attenuation\.tau_s: found 0\.0"),
    ],
)
def test_an_effect_outside_of_its_domain_is_refused(kind, values, message):
    with pytest.raises(InvalidParameter, match=message):
        effect(kind, **values)


@pytest.mark.parametrize(
    ("kind", "values", "message"),
    [
        ("patches", {"side_m": 0.03}, r"patches: .*raise inset_m to 0\.015 or lower side_m"),
        ("attenuation", {"tau_s": float("inf")}, r"attenuation\.tau_s: found inf, .* omit the effect if"),
        ("audible_filter", {}, r"audible_filter: .*lower cutoff_hz or raise f_max_hz"),
        ("pulse_width", {"carrier_hz": 20e3}, r"PulseWidth\.carrier_hz: .*lower it or raise rate_hz"),
    ],
)
def test_unsuitable_effect_is_refused_with_fix(kind, values, message):
    with pytest.raises(InvalidParameter, match=message):
        screen(effect(kind, **values)).resolve()


def test_a_finger_off_the_plate_is_refused():
    scene = replace(screen(effect("finger_load")), contacts=(FingerContact(1.0, x_m=0.3, y_m=0.01),))
    with pytest.raises(
        InvalidParameter, match=r"contacts\[0\]: found \(0\.3, 0\.01\) m, expected a place on the plate"
    ):
        run(scene)


def test_sliding_finger_on_focus_is_refused_with_fix():
    slides = replace(screen(), contacts=(FingerContact(2.0), FingerContact(2.0, speed_m_per_s=0.05)))
    message = r"contacts\[1\]: found a finger that slides \(0.05 m/s\) on a plate that focuses, .*'hybrid'"
    with pytest.raises(InvalidParameter, match=message):
        slides.resolve()


def test_impossible_losses_are_refused():
    with pytest.raises(
        InvalidParameter, match=r"attenuation\.exponent: found 1e\+08, by which tau changes .* lower it"
    ):
        screen(effect("attenuation", exponent=1e8)).resolve()
