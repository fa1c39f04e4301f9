"""Accuracy and cost of hybrid scenes on both sides."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from scene_cases import FOCUSED, LEVEL, RUBBED, VOLT, between_events, effect, finest_of, hybrids, small_screen
from scene_errors import error_of
from soak import SOAK

from tactometry.signal import Signal
from tactometry.stimuli.composition.effect import FingerContact
from tactometry.stimuli.electrovibration import Sine, Skin
from tactometry.stimuli.electrovibration.attraction.contact_area import PowerLawArea
from tactometry.stimuli.electrovibration.attraction.force import electrostatic_force_n_at
from tactometry.stimuli.scenes.scene import Scene
from tactometry.stimuli.scenes.surfaces.electrovibration import Electrovibration
from tactometry.stimuli.scenes.surfaces.hybrid import HybridScreen
from tactometry.stimuli.time_reversal.filters import Band
from tactometry.stimuli.time_reversal.fingertip import Fingertip
from tactometry.stimuli.time_reversal.focusing.focusing import drive, emitted
from tactometry.stimuli.time_reversal.focusing.one_bit import OneBit
from tactometry.stimuli.time_reversal.plate.glass import BOROFLOAT_33
from tactometry.stimuli.time_reversal.responses.load import loaded_responses
from tactometry.stimuli.time_reversal.responses.responses import band_limited, impulse_responses
from tactometry.stimuli.time_reversal.screen.attenuation import Attenuation
from tactometry.stimuli.time_reversal.screen.screen import Screen
from tactometry.stimuli.time_reversal.screen.transducer import border

ACCURACIES = (1e-1, 1e-2, 1e-3, 1e-4)
REST, SLIDE = FingerContact(2.0), FingerContact(1.0, 0.05, 0.09, 0.06)
EFFECTS = (
    effect("attenuation", tau_s=2e-3), effect("patches", side_m=8e-3), effect("one_bit"), effect("finger_load"),
    effect("force_law", law="sc_layer"), effect("skin_leakage"), effect("contact_area"), effect("friction"),
)  # fmt: skip
SCENE = Scene(
    HybridScreen(Electrovibration(60.0, duration_s=0.05, ramp_s=0.01), small_screen()),
    EFFECTS,
    ("t_s", *FOCUSED, "sliding_t_s", *RUBBED),
    contacts=(SLIDE, REST),
)


def run(scene):
    return scene.resolve().run({**VOLT, **LEVEL})


def error(got, reference, output):
    if output not in RUBBED:
        return error_of(got, reference, output)
    t_s, at_s = got["sliding_t_s"], reference["sliding_t_s"]
    jumps = got.get("slip_events_s", ()) if output == "friction_force_n" else ()
    off = np.abs(np.interp(at_s, t_s, got[output]) - reference[output]) / np.abs(reference[output]).max()
    return float(off[between_events(t_s, jumps, at_s)].max())


# --- against the physics of each side, computed in another way

FOCUS, PLATE_HZ = (0.05, 0.04), 60e3
OF_REFERENCE = 3e-4
"""What is left of the first-order error of sampling in `in_time`."""


def sampled(factor):
    """Return the focus under both fingers, shape (n,).

    From 3 ms before to 0.9 ms after, stepped at a multiple of the clock.
    """
    plate = BOROFLOAT_33.plate(0.12, 0.09, 1.1e-3, "SSSS")
    whole = Screen(plate, tuple(border(plate, 8, 8e-3)), Attenuation(2e-3))
    band = Band(0.0, 15e3, 3e3)
    raw = impulse_responses(whole, [FOCUS], rate_hz=PLATE_HZ, duration_s=3e-3, f_max_hz=15e3)
    signal = drive(band_limited(raw, band), 30.0, OneBit())
    n = signal.samples.shape[1]
    spectrum = np.fft.rfft(np.pad(signal.samples, ((0, 0), (n, n))))
    finely = factor * np.fft.irfft(spectrum * band.at(np.fft.rfftfreq(3 * n, 1 / PLATE_HZ)), 3 * n * factor)
    fingers = [Fingertip().load(FOCUS, 2.0), Fingertip().load((0.09, 0.06), 1.0)]
    sampling = {"rate_hz": factor * PLATE_HZ, "duration_s": 12e-3, "f_max_hz": 25e3 * factor}
    course = emitted(Signal(finely, factor * PLATE_HZ, "V"), loaded_responses(whole, [FOCUS], fingers, **sampling))[0]
    focus = factor * (2 * n - 1)
    return course[focus - 180 * factor : focus + 54 * factor + 1]


@pytest.fixture(scope="module")
def in_time():
    """Extrapolate two time-domain runs to steps of zero length."""
    course = 2 * sampled(8)[::2] - sampled(4)
    return {"t_s": (np.arange(course.size) - 720) / 240e3, "focus_displacement_m": course}


@pytest.mark.parametrize("accuracy", ACCURACIES)
def test_focus_under_two_fingers_matches_time_domain(in_time, accuracy):
    got = run(replace(SCENE, accuracy=accuracy))
    assert error(got, in_time, "focus_displacement_m") <= accuracy + OF_REFERENCE


@pytest.mark.parametrize("accuracy", ACCURACIES)
def test_sliding_friction_matches_exact_circuit(accuracy):
    got = run(replace(SCENE, accuracy=accuracy))
    t_s = np.linspace(0.0, 0.05, 20_001)
    pieces, area_m2 = Sine(60.0, duration_s=0.05, ramp_s=0.01).pieces(40.0), float(PowerLawArea().area_m2(1.0))
    force_n = electrostatic_force_n_at(t_s, pieces, skin=Skin(), area_m2=area_m2, law="sc_layer")
    slid = {"sliding_t_s": t_s, "electrostatic_force_n": force_n, "friction_force_n": MU * (1.0 + force_n)}
    for output in RUBBED:
        assert error(got, slid, output) <= accuracy


MU = 0.5 * 0.05 / np.hypot(0.05, 1e-3)


# --- against much finer runs


def test_hybrid_accuracy_is_met_and_looser_costs_less():
    reference, costs = run(replace(SCENE, accuracy=2e-5)), []
    for accuracy in ACCURACIES:
        plan = replace(SCENE, accuracy=accuracy).resolve()
        got = plan.run({**VOLT, **LEVEL})
        true = max(error(got, reference, output) for output in (*FOCUSED, *RUBBED))
        assert true <= plan.error <= accuracy
        assert plan.error <= 10 * max(true, accuracy / 10)
        costs.append(plan.n_operations)
    assert costs == sorted(set(costs))


@given(hybrids())
@settings(max_examples=200 if SOAK else 6, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_random_hybrid_scenes_keep_their_accuracy_on_both_sides(scene):
    finest, costs = finest_of(scene, 1e-4, 3e-4, 9e-4), []
    reference = run(finest)
    for accuracy in ACCURACIES[:3]:
        plan = replace(scene, accuracy=accuracy).resolve()
        got = plan.run({**VOLT, **LEVEL})
        for output in {*FOCUSED, *RUBBED} & set(scene.outputs):
            assert error(got, reference, output) <= accuracy + finest.accuracy
        costs.append(plan.n_operations)
    assert costs == sorted(costs)
    assert costs[0] < costs[-1]
