"""Sensation of a signal through a scene, and refused signals."""

from dataclasses import dataclass, replace
from math import inf
from typing import ClassVar

import numpy as np
import pytest
from scene_cases import default, effect, small_screen
from scipy.signal import resample

from tactometry.contact import Contact
from tactometry.experiments.scenes import path_of
from tactometry.stimuli.composition.effect import Effect, FingerContact
from tactometry.stimuli.electrovibration import AmplitudeModulated, CoulombFriction, PulseTrain, Sine, Skin, Square
from tactometry.stimuli.electrovibration.attraction.force import force_form
from tactometry.stimuli.electrovibration.motion.friction_lag import FrictionLag
from tactometry.stimuli.electrovibration.waveforms.pieces import VoltageRecord
from tactometry.stimuli.electrovibration.waveforms.sampled import Sampled
from tactometry.stimuli.hybrid import Hybrid
from tactometry.stimuli.perception.detection import components
from tactometry.stimuli.scenes.effects import OF_ELECTROVIBRATION
from tactometry.stimuli.scenes.effects.sensitivity import Sensitivity
from tactometry.stimuli.scenes.file import load_scene
from tactometry.stimuli.scenes.plan import Plan
from tactometry.stimuli.scenes.scene import Scene
from tactometry.stimuli.scenes.stages import record
from tactometry.stimuli.scenes.surfaces.electrovibration import Electrovibration, PlayedElectrovibration
from tactometry.stimuli.time_reversal.stimulus.focus_train import FocusTrain

FELT = ("force_law", "friction", "sensitivity")
TOUCH = Contact(1.5, 0.05)
TONES = {
    "sine": (Sine(60.0, 0.5), (), 120.0, 1 / 2),
    "sine at another rate": (Sine(60.0, 0.5, rate_hz=48_000.0), (), 120.0, 1 / 2),
    "level in volt": (Sine(60.0, 0.5, level_unit="V"), (), 120.0, 1 / 2),
    "carrier": (AmplitudeModulated(240.0, duration_s=0.5), (effect("carrier"),), 240.0, 1 / 4),
}
"""A stimulus, what of it is an effect, and by hand: the frequency of its force, and the amplitude there over V^2."""


def felt(*kinds, played=(), tone=60.0, **surface):
    panel = Electrovibration(tone, **{"duration_s": 0.5, **surface})
    effects = (*(default(kind) for kind in (*FELT, *kinds)), *played)
    return Scene(panel, effects, ("sensation_db",), 0.05, (FingerContact(1.0, 0.01),))


def pulp_m_per_n(frequency_hz):
    """Return the default spring, damper and mass as a phasor."""
    omega = 2 * np.pi * frequency_hz
    return 1 / np.abs(1000.0 - 0.15e-3 * omega**2 + 1.5j * omega)


def by_hand_db(frequency_hz, share, voltage_v, contact, lag):
    """Return the level of one friction component in closed form."""
    skin = Skin(corneum_resistivity_ohm_m=inf)
    layer_v = skin.k * voltage_v
    force_n = force_form("sc_layer", skin, 1e-4).force_n(np.array([layer_v]))[0]
    gain = FrictionLag().gain(frequency_hz, contact.speed_m_per_s) if lag else 1.0
    skin_m = 0.5 * share * force_n * gain * pulp_m_per_n(frequency_hz)
    return 20 * np.log10(skin_m / 1e-7) - 12 * abs(np.log2(250 / frequency_hz))


@pytest.mark.parametrize("lag", [False, True])
@pytest.mark.parametrize("name", TONES)
def test_sensation_level_matches_closed_form(name, lag):
    stimulus, played, frequency_hz, share = TONES[name]
    tone = stimulus.frequency_hz
    scene = felt(*(["friction_lag"] if lag else []), played=played, tone=tone)
    level = 30.0 if stimulus.level_unit == "V" else 20 * np.log10(30.0)
    for contact in (TOUCH, Contact(0.7, 0.1)):
        expected_db = by_hand_db(frequency_hz, share, 30.0, contact, lag)
        assert scene.sensation(stimulus.at(level), contact) == pytest.approx(expected_db, abs=0.02)


def test_lag_of_components_matches_time_course():
    """The steady state of the lag, against its exact solution."""
    scene = felt("friction_lag", "skin_leakage")
    touched = replace(scene, contacts=(FingerContact(1.5, 0.05),), accuracy=1e-3)
    exact_db = touched.resolve().run({"level_db_re_1v": 30.0})["sensation_db"]
    assert scene.sensation(Sine(60.0, 0.5).at(30.0), TOUCH) == pytest.approx(exact_db, abs=1e-3)


def test_receptors_and_masking_act_after_the_skin():
    scene = replace(felt(), effects=tuple(default(k) for k in ("force_law", "friction", "receptors")))
    signal = Sine(60.0, 0.5).at(40.0)
    masked = replace(scene, effects=(*scene.effects, effect("masking", level_db_re_threshold=25.0)))
    assert scene.sensation(signal, TOUCH) - masked.sensation(signal, TOUCH) == pytest.approx(0.52 * 25.0)


WAVEFORMS = {
    "another tone": Sine(61.0, 0.3, phase_rad=0.1),
    "pulses": PulseTrain(60.0, width_s=1e-3, duration_s=0.5),
    "square": Square(60.0, duration_s=0.5),
    "noise": Sampled(tuple(np.random.default_rng(7).normal(size=10_000)), rate_hz=20_000.0),
    "close to half of the rate": Sine(9_000.0, 0.5, rate_hz=20_000.0),
}


@pytest.mark.parametrize("name", WAVEFORMS)
def test_any_voltage_is_felt_as_its_samples_say(name):
    """Against the force law on a finer record, which cannot alias."""
    signal = WAVEFORMS[name].at(30.0)
    (voltage_v,) = signal.samples
    finer_v = resample(voltage_v, 4 * voltage_v.size)
    form = force_form("sc_layer", Skin(corneum_resistivity_ohm_m=inf), 1e-4)
    friction_n = CoulombFriction()(TOUCH).coefficient_at(TOUCH.force_n) * form.force_n(
        form.relaxations.sampled(finer_v, signal.rate_hz)
    )
    rate_hz = signal.rate_hz * finer_v.size / voltage_v.size
    parts = components(friction_n, rate_hz)
    expected_db = Sensitivity()(replace(parts, amplitudes=parts.amplitudes * pulp_m_per_n(parts.frequencies_hz)))
    assert felt().sensation(signal, TOUCH) == pytest.approx(expected_db, abs=0.1)


def test_a_body_and_a_grating_depend_on_the_contact():
    """Against the time course of the same scene with that contact."""
    added = effect("body_resistance", resistance_ohm=3e4), effect("texture", period_m=1e-3), default("contact_area")
    for kinds in (added[:1], added[1:2], added):
        scene = replace(felt("skin_leakage"), effects=(*felt("skin_leakage").effects, *kinds))
        for touch in (FingerContact(0.5, 0.05), FingerContact(2.0, 0.08)):
            touched = replace(scene, contacts=(touch,), accuracy=2e-2)
            expected_db = touched.resolve().run({"level_db_re_1v": 30.0})["sensation_db"]
            signal, contact = Sine(60.0, 0.5, rate_hz=100_000.0).at(30.0), Contact(touch.force_n, touch.speed_m_per_s)
            assert scene.sensation(signal, contact) == pytest.approx(expected_db, abs=0.01)


def test_stick_slip_sensation_follows_time_course():
    kinds = ("force_law", "dry_friction", "finger_dynamics", "sensitivity")
    scene = replace(felt(), effects=tuple(default(kind) for kind in kinds), accuracy=1e-3)
    touched = replace(scene, contacts=(FingerContact(0.5, 0.05),))
    expected_db = touched.resolve().run({"level_db_re_1v": 40.0})["sensation_db"]
    signal = Sine(60.0, 0.5, rate_hz=100_000.0).at(40.0)
    assert scene.sensation(signal, Contact(0.5, 0.05)) == pytest.approx(expected_db, abs=0.1)


@dataclass(frozen=True)
class Sweat(Effect):
    """A custom effect that changes the time course of friction."""

    kind = slot = "sweat"
    reads, gives = ("friction_force_n",), "friction_force_n"

    left_share: float

    def __call__(self, friction_force_n):
        return self.left_share * friction_force_n


class Sweaty(PlayedElectrovibration):
    effects: ClassVar = {**OF_ELECTROVIBRATION, "sweat": ""}


@pytest.mark.parametrize("kinds", [(), ("contact_area",), ("friction_lag",), ("body_resistance",)])
def test_custom_effect_on_friction_changes_sensation(kinds):
    scene = replace(felt(*kinds), surface=Sweaty())
    signal, touch = Sine(60.0, 0.5).at(30.0), Contact(2.0, 0.05)
    whole, half = (
        replace(scene, effects=(*scene.effects, Sweat(share))).sensation(signal, touch) for share in (1, 0.5)
    )
    assert half - whole == pytest.approx(20 * np.log10(0.5), abs=1e-9)
    assert whole == pytest.approx(
        scene.sensation(signal, touch), abs=0.01
    )  # components of a lag are in their steady state


PLATE = (effect("attenuation", tau_s=2e-3), effect("patches", side_m=8e-3))


@pytest.mark.parametrize("kinds", [(), ("finger_load",)])
def test_focus_stimulus_sensation_matches_scene_drive(kinds):
    """The scene computes its own modes and drive: 0.07 dB difference."""
    others = (effect(kind) for kind in ("one_bit", *kinds, "focus_detection"))
    scene = Scene(small_screen(), (*PLATE, *others), ("sensation_db",), 0.02, (FingerContact(1.5),))
    drive = FocusTrain(scene.felt().surface.setup, f_max_hz=15e3).at(0.0)
    level_db = scene.resolve().run({"voltage_v": drive.peak})["sensation_db"]
    assert scene.sensation(drive, Contact(1.5)) == pytest.approx(level_db, abs=0.2)


@pytest.mark.parametrize("place", [{"x_m": 0.03, "y_m": 0.02}, {"y_m": 0.06}], ids=str)
def test_finger_off_focus_feels_its_own_place(place):
    """Against a finger with hardly any load and the stimulus's plate.

    Samples of the stimulus miss a wave's peak by up to 1 dB; the focus is at least 8 dB stronger.
    """
    scene = Scene(small_screen(flank_hz=500.0), (*PLATE, effect("focus_detection")), ("sensation_db",), 1e-3)
    drive = FocusTrain(scene.felt().surface.setup, drive="analogue", f_min_hz=1e-3, f_max_hz=15e3).at(0.0)
    touched = replace(scene, contacts=(FingerContact(1.5, **place),))
    faint = replace(touched, effects=(*scene.effects, effect("finger_load", resistance_n_s_per_m=1e-9)))
    at_focus_db, level_db, loaded_db = (
        one.resolve().run({"voltage_v": drive.peak})["sensation_db"] for one in (scene, touched, faint)
    )
    assert level_db == pytest.approx(loaded_db, abs=0.02)
    assert touched.sensation(drive, Contact(1.5)) == pytest.approx(level_db, abs=1.0)
    assert level_db < at_focus_db - 8


def test_played_plate_includes_all_plate_effects():
    effects = (*PLATE, effect("edges", boundary="FFFF"), effect("shear"), effect("focus_detection"))
    touch = FingerContact(1.5, x_m=0.03, y_m=0.02)
    played = Scene(small_screen(), effects, ("sensation_db",), contacts=(touch,)).felt().surface
    assert (played.finger_x_m, played.finger_y_m) == (0.03, 0.02)
    assert {name: getattr(played.setup, name) for name in OF_PLATE} == OF_PLATE


OF_PLATE = {"tau_s": 2e-3, "side_m": 8e-3, "boundary": "FFFF", "shear_factor": 5 / 6, "modes_to_hz": 18e3}


def test_screen_sensation_ignores_airborne_sound():
    screen, drive = load_scene(path_of("a4-screen")).scene, FocusTrain().at(20.0)
    silent = replace(screen, effects=tuple(one for one in screen.effects if one.kind != "airborne_sound"))
    silent = replace(silent, outputs=("sensation_db",))
    assert screen.sensation(drive, Contact(2.0)) == silent.sensation(drive, Contact(2.0))


def test_hybrid_screen_sensation_is_the_stronger_side():
    screen = load_scene(path_of("hybrid-screen")).scene
    drives = Hybrid(FocusTrain(), AmplitudeModulated(120.0, duration_s=0.5, rate_hz=250e3))
    friction = Scene(
        screen.surface.electrovibration,
        tuple(one for one in screen.effects if one.kind in OF_ELECTROVIBRATION),
        ("sensation_db",),
        screen.accuracy,
        (FingerContact(1.0, 0.05),),
    )
    foci = replace(
        screen,
        surface=screen.surface.time_reversal,
        effects=tuple(one for one in screen.effects if one.kind not in OF_ELECTROVIBRATION),
        contacts=(FingerContact(1.0),),
    )
    signal, level_db = drives.at(28.0), 28.0 + drives.electrode_offset_db
    slid = friction.sensation(drives.friction.at(level_db), Contact(1.0, 0.05))
    rested = foci.sensation(drives.focus.at(28.0), Contact(1.0))
    assert screen.sensation(signal, Contact(1.0)) == pytest.approx(rested, abs=1e-6)
    assert screen.sensation(signal, Contact(1.0, 0.05)) == pytest.approx(max(rested, slid), abs=1e-6)


def test_sensation_resolves_once_and_caches_spectra(monkeypatch):
    scene, resolved, read, ran = felt(), [], [], []
    kept, spectrum, run = Scene.resolve, record.components_of_record, Plan.run
    monkeypatch.setattr(Scene, "resolve", lambda self: resolved.append(self) or kept(self))
    monkeypatch.setattr(record, "components_of_record", lambda *a, **k: read.append(a) or spectrum(*a, **k))
    monkeypatch.setattr(Plan, "run", lambda self, given: ran.append(tuple(given)) or run(self, given))
    for level in (20.0, 30.0):
        for contact in (TOUCH, Contact(1.0, 0.05), TOUCH):
            scene.sensation(Sine(60.0, 0.5).at(level), contact)
    assert (len(resolved), len(read)) == (1, 2)
    assert (ran.count(("signal",)), sum("contact" in given for given in ran)) == (2, 4)


def test_imperceptible_lines_are_dropped():
    """A carrier has hundreds of lines: 60 Hz is felt, 4 kHz is not."""
    t_s = np.arange(20_000) / 20_000.0
    course = np.sin(2 * np.pi * 60 * t_s) + np.sin(2 * np.pi * 4000 * t_s)
    found = record.components_of_record(VoltageRecord(course, 20_000.0), course, 1)
    strong = found.amplitudes > 1e-6
    assert found.frequencies_hz[strong] == pytest.approx([60.0], abs=0.01)
    assert found.frequencies_hz.max() <= 800.0
