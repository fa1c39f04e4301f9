"""Refusals of contradictory, invalid or too costly scenes, each in one sentence with its remedy."""

from dataclasses import replace

import numpy as np
import pytest
from scene_cases import default, effect, panel, screen, small_screen
from scene_errors import LOSSY

from tactometry.contact import Contact
from tactometry.errors import InvalidParameter
from tactometry.signal import Signal
from tactometry.stimuli.composition.effect import FingerContact
from tactometry.stimuli.electrovibration import Sine
from tactometry.stimuli.scenes.scene import Scene
from tactometry.stimuli.scenes.surfaces.electrovibration import Electrovibration
from tactometry.stimuli.scenes.surfaces.time_reversal import TimeReversal

TONE, SIGNAL, TOUCH = Electrovibration(60.0, duration_s=0.5), Sine(60.0, 0.5).at(30.0), Contact(1.5, 0.05)
TOTAL_THICKNESS = effect("force_law", law="total_thickness")
SMALL, LARGE = small_screen(), TimeReversal(reversal_s=1e-3)
SUDDEN = Electrovibration(60.0, duration_s=0.05, ramp_s=0.0)
FELT = panel(default("friction"), default("sensitivity"), outputs=("sensation_db",))
UNFELT = panel(default("friction"), outputs=("peak_force_n",))


def pressed(*effects, contacts=(), surface=SMALL, accuracy=0.01):
    return Scene(surface, effects, ("peak_m",), accuracy, contacts)


EFFECTS = [
    (lambda: screen(effect("one_bit"), effect("sigma_delta")),
     "effects[1]: found 'sigma_delta' with 'one_bit', expected only one of them in the slot quantiser; remove the"),
    (lambda: screen(LOSSY, LOSSY), "effects[1]: found 'attenuation' with 'attenuation', expected only one of them in"),
    (lambda: screen(effect("airborne_sound")),
     "effects[0]: found 'airborne_sound' without an effect in slot attenuation, expected one; add it or remove"),
    (lambda: screen(effect("shear"), effect("finger_load")),
     "effects[1]: found 'finger_load' with 'shear', expected only one of them: a force at a point sinks into a plate"),
    (lambda: screen(effect("friction")), "effects[0]: found 'friction', which 'time_reversal' does not support,"),
    (lambda: pressed(effect("lift_off"), contacts=(FingerContact(0.05),)),
     "effects[0]: found 'lift_off' without an effect in slot load, expected one; add it or remove 'lift_off'"),
    (lambda: pressed(effect("finger_load")), "effects[0]: found 'finger_load' without a resting contact, expected one"),
    (lambda: pressed(effect("finger_load"), contacts=(FingerContact(1.0, 0.05),)),
     "effects[0]: found 'finger_load' without a resting contact, expected one; add a [[contacts]] table with force_n"),
    (lambda: panel(default("friction"), default("dry_friction")),
     "effects[2]: found 'dry_friction' with 'friction', expected only one of them in the slot friction; remove the"),
    (lambda: panel(default("friction"), default("polarity"), default("friction_lag")),
     "effects[2]: found 'polarity' with 'friction_lag', expected only one of them: the exact motion has no term for"),
    (lambda: panel(default("friction_lag")), "effects[1]: found 'friction_lag' without an effect in slot friction,"),
    (lambda: panel(default("dry_friction")), "effects[1]: found 'dry_friction' without an effect in slot dynamics,"),
    (lambda: panel(effect("force_law", law="interface")),
     "effects[1]: found 'force_law' with 'force_law', expected only one of them in the slot law; remove the other"),
    (lambda: panel(effect("friction"), effect("sensitivity"), effect("receptors")),
     "effects[2]: found 'sensitivity' with 'receptors', expected only one of them: both set the threshold over"),
    (lambda: panel(effect("friction"), effect("sensitivity"), effect("summation")),
     "effects[3]: found 'summation' without an effect in slot receptors, expected one; add it or remove 'summation'"),
    (lambda: replace(panel(), effects=(default("friction"),), contacts=()),
     "effects[0]: found 'friction' without a sliding contact, expected one; add a [[contacts]] table with force_n and"),
    (lambda: Scene(TONE, (TOTAL_THICKNESS, default("skin_leakage")), ("peak_force_n",)).resolve(),
     "force_law: found 'total_thickness' with 'skin_leakage', which that law ignores, expected the law interface or"),
    (lambda: replace(panel(default("dc_offset")), surface=SUDDEN).resolve(),
     "dc_offset: found a constant without a ramp (ramp_s = 0), expected ramps; set ramp_s of the tone above 0"),
    (lambda: replace(panel(default("skin_leakage")), surface=SUDDEN).resolve(),
     "skin_leakage: found a tone without a ramp (ramp_s = 0), expected a ramp; set ramp_s of the tone above 0"),
    (lambda: replace(panel(default("body_resistance")), surface=SUDDEN).resolve(),
     "body_resistance: found a tone without a ramp (ramp_s = 0), expected a ramp; set ramp_s of the tone above 0"),
    (lambda: panel(outputs=("friction_force_n",)).resolve(),
     "outputs: found no stage or effect for 'friction_force_n', expected one of area_m2, electrostatic_force_n,"),
    (lambda: Scene(TONE, (), ("peak_force_n",)).resolve(),
     "scene: found no stage or effect for 'form', which 'electrostatic_force_n' needs, expected one of area_m2,"),
]  # fmt: skip
VALUES = [
    (lambda: small_screen(glass="Borofloat"), "TimeReversal.glass: found 'Borofloat', expected one of Borofloat 33,"),
    (lambda: small_screen(focus_x_m=0.2), "TimeReversal.focus_x_m: found 0.2, expected a place between the edges, 0"),
    (lambda: small_screen(f_max_hz=40e3), "TimeReversal.f_max_hz: found 40000.0, expected at most half of rate_hz,"),
    (lambda: small_screen(flank_hz=20e3), "TimeReversal.flank_hz: found 20000.0, expected at most f_max_hz, 15000.0"),
    (lambda: small_screen(inset_m=0.05), "TimeReversal.inset_m: found 0.05, expected less than half of the shorter"),
    (lambda: small_screen(n_transducers=0), "TimeReversal.n_transducers: found 0, expected a whole number, at least 1"),
    (lambda: effect("edges", boundary="SSSS"),
     "Edges.boundary: found 'SSSS', the default of a plate, expected other edges; remove the effect"),
    (lambda: effect("edges", boundary="SSXF"),
     "Edges.boundary: found 'SSXF', expected four letters of S, C, F, such as 'FFFF'"),
    (lambda: effect("temperature_drift", kelvin=3e4),
     "TemperatureDrift.shift_of_frequencies: found -1.5, expected a number from -0.1 to 0.1"),
    (lambda: effect("temperature_drift", kelvin=0.0),
     "TemperatureDrift.kelvin: found 0.0, expected a finite number other than 0; omit the effect if there is no drift"),
    (lambda: effect("foci", x_m=(0.1,), y_m=()),
     "Foci.x_m: found 1 places but 0 of y_m, expected equal numbers, at least one"),
    (lambda: effect("sigma_delta", order=3), "SigmaDelta.order: found 3, expected 1 or 2"),
    (lambda: effect("repetition", envelope="sync"),
     "Repetition.envelope: found 'sync', expected one of rectangular, raised_cosine, exponential, sinc; did you mean"),
    (lambda: effect("finger_load", resistance_n_s_per_m=0.0),
     "FingerLoad.load: found 0.0, expected a finite number above 0"),
    (lambda: effect("attenuation", tau_s=0.0), "Attenuation.tau_s: found 0.0, expected a time above 0, or inf"),
    (lambda: screen(effect("attenuation", exponent=1e8)).resolve(),
     "attenuation.exponent: found 1e+08, by which tau changes 1.76e+07 decades up to f_max_hz, expected at most 12;"),
    (lambda: screen(effect("attenuation", tau_s=float("inf"))).resolve(),
     "attenuation.tau_s: found inf, expected a finite time; omit the effect if there are no losses"),
    (lambda: screen(effect("patches", side_m=0.03)).resolve(),
     "patches: found a side of 0.03 m with TimeReversal.inset_m = 0.012, expected patches within the plate; raise"),
    (lambda: screen(effect("audible_filter")).resolve(),
     "audible_filter: found a flank up to 22000.0 Hz, expected it below the band's flank at 12000.0 Hz; lower"),
    (lambda: screen(effect("pulse_width", carrier_hz=20e3)).resolve(),
     "PulseWidth.carrier_hz: found 20000.0, expected at most a quarter of the rate, 15000.0 Hz; lower it or raise"),
    (lambda: screen(effect("finger_load", mass_kg=1e-4), effect("lift_off")).resolve(),
     "FingerLoad.mass_kg: found 0.0001, expected 0 with lift_off, as no law of impact is available"),
    (lambda: screen(effect("movie", span_s=0.01), outputs=("movie_m",)).resolve(),
     "movie: found a span of 0.01 s, expected at most 0.002, twice the shorter of reversal_s and after_s; shorten it"),
    (lambda: pressed(effect("finger_load"), contacts=(FingerContact(1.0, x_m=0.3, y_m=0.01),)).resolve(),
     "contacts[0]: found (0.3, 0.01) m, expected a place on the plate of 0.12 x 0.09 m"),
    (lambda: pressed(contacts=(FingerContact(2.0), FingerContact(2.0, speed_m_per_s=0.05))).resolve(),
     "contacts[1]: found a finger that slides (0.05 m/s) on a plate that focuses, expected one at rest; remove"),
    (lambda: replace(FELT, outputs="sensation_db"), "Scene.outputs: found 'sensation_db', expected a tuple or a list"),
    (lambda: replace(FELT, effects=("friction",)), "Scene.effects[0]: found 'friction', expected a Effect"),
    (lambda: replace(FELT, contacts=(1.0,)), "Scene.contacts[0]: found 1.0, expected a FingerContact"),
    (lambda: replace(FELT, surface=None), "Scene.surface: found None, expected a Surface"),
    (lambda: replace(FELT, accuracy="fine"), "Scene.accuracy: found fine, expected a number above 0 and at most 1"),
    (lambda: replace(FELT, accuracy=0.0), "Scene.accuracy: found 0.0, expected a number above 0 and at most 1"),
    (lambda: replace(FELT, accuracy=1.5), "Scene.accuracy: found 1.5, expected a number above 0 and at most 1"),
    (lambda: replace(FELT, accuracy=float("nan")),
     "Scene.accuracy: found nan, expected a number above 0 and at most 1"),
]  # fmt: skip
COSTS = [
    (lambda: Scene(TimeReversal(), (LOSSY,), ("field_m",), 5e-5).resolve(),
     "field_m: found an error budget of 2.5e-05 for a grid, which takes 9787 x 6921 points, expected at most 4e+07 in"),
    (lambda: pressed(surface=small_screen(reversal_s=30.0), accuracy=1e-3).resolve(),
     "accuracy: found an error budget of 0.001 for the modes, which takes 4.9e+07 numbers, expected at most 4.5e+07;"),
    (lambda: pressed(effect("edges", boundary="FFFF"), LOSSY, surface=LARGE, accuracy=1e-7).resolve(),
     "accuracy: found an error budget of 1e-07 for the modes, 614549 modes of a plate whose edges are not simply"),
    (lambda: panel(default("carrier"), default("skin_leakage"), accuracy=1e-8).resolve(),
     "accuracy: found an error budget of 1e-08 for 'sampling', expected at least 4e-06, the error of its finest"),
    (lambda: panel(default("friction"), default("sensitivity"), outputs=("sensation_db",), accuracy=1e-9).resolve(),
     "accuracy: found an error budget of 5e-10 for 'spectrum', expected at least 4.3e-06, the error of its finest"),
]  # fmt: skip
SENSATIONS = [
    (lambda: FELT.sensation(None, TOUCH), "Scene.sensation.signal: found None, expected a Signal"),
    (lambda: FELT.sensation(np.zeros(9), TOUCH),
     "Scene.sensation.signal: found array([0., 0., 0., 0., 0., 0., 0., 0., 0.]), expected a Signal"),
    (lambda: FELT.sensation(SIGNAL, 1.5), "Scene.sensation.contact: found 1.5, expected a Contact or a FingerContact"),
    (lambda: FELT.sensation(Signal(np.ones((2, 10_000)), 20_000.0, "V"), TOUCH),
     "signal: found 2 channels in 'V', expected one channel in volt ('V')"),
    (lambda: UNFELT.sensation(SIGNAL, TOUCH), "outputs: found no stage or effect for 'sensation_db', expected one of"),
    (lambda: pressed().sensation(SIGNAL, Contact(1.0)),
     "effects: found a plate without losses or patches for a played signal, expected both, as in a stimulus; add"),
    (lambda: pressed(effect("attenuation", exponent=0.5)).sensation(SIGNAL, Contact(1.0)),
     "attenuation.exponent: found 0.5 for a played signal, expected 0: the plate of a stimulus has one tau_s"),
]  # fmt: skip


@pytest.mark.parametrize(("call", "message"), EFFECTS + VALUES + COSTS + SENSATIONS)
def test_scene_is_refused_in_one_sentence(call, message):
    with pytest.raises(InvalidParameter) as caught:
        call()
    assert str(caught.value).startswith(message)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("scene", "remedy"),
    [
        (panel(outputs=("friction_force_n",)), "; add the effect friction"),
        (Scene(TONE, (), ("peak_force_n",)), "name one of the four laws"),
        (replace(UNFELT, outputs=("sensation_db",)), "sensitivity, or receptors"),
        (pressed(effect("edges", boundary="FFFF"), LOSSY, surface=LARGE, accuracy=1e-7), "remove 'edges'"),
        (pressed(surface=small_screen(reversal_s=30.0), accuracy=1e-3), "reversal_s"),
        (panel(default("carrier"), default("skin_leakage"), accuracy=1e-8), "loosen the accuracy"),
    ],
)
def test_refused_scene_names_its_remedy(scene, remedy):
    with pytest.raises(InvalidParameter, match=remedy):
        scene.resolve()
