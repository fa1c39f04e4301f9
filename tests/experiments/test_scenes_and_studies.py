"""Agreement of built-in scenes and studies on the same stimulus.

They differ only by effects that are reported.
"""

from dataclasses import replace

import numpy as np
import pytest

from tactometry.contact import Contact
from tactometry.experiments.scenes import path_of
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.felt_effects import felt_effects
from tactometry.experiments.study.study_file import load, parse
from tactometry.stimuli.electrovibration import AmplitudeModulated, ElectrovibrationSensation
from tactometry.stimuli.scenes.default_scenes import default_scene
from tactometry.stimuli.scenes.file import load_scene
from tactometry.stimuli.time_reversal.stimulus.focus_train import FocusTrain
from tactometry.stimuli.time_reversal.stimulus.sensation import TimeReversalSensation
from tactometry.stimuli.time_reversal.stimulus.setup import Setup

SAME = {
    "tutorial": ("electrovibration-panel", set()),
    "electrovibration-threshold": ("electrovibration-panel", set()),
    "time-reversal-threshold": ("a4-screen", {"finger_load"}),
    "hybrid-button": ("hybrid-screen", {"finger_load"}),
}
"""Of a study the built-in scene on its surface, and what that has more."""
BY_DEFAULT = {"skin_mobility"}
"""What a panel does at its defaults without being asked."""
TOUCHES = Contact(1.5, 0.05), Contact(0.5, 0.02)


def wired(study, more=""):
    return wire(parse(load(study)[1] + more.encode(), "s.toml"), "s.toml")


def without(scene, kinds):
    return replace(scene, effects=tuple(one for one in scene.effects if one.kind not in kinds))


@pytest.mark.parametrize("study", SAME)
def test_study_equals_built_in_scene_of_surface(study):
    name, more = SAME[study]
    pairs = zip(wired(study).cells.values(), wired(study, f'\n[scene]\nname = "{name}"\n').cells.values(), strict=True)
    for default, named in {cell.condition.stimulus: (cell, other) for cell, other in pairs}.values():
        stated = [{one.kind for one in cell.sensation.scene.effects} - BY_DEFAULT for cell in (default, named)]
        assert stated[1] - stated[0] <= more
        assert stated[0] <= stated[1]
        signal, alike = default.stimulus.at(12.0), without(named.sensation.scene, more)
        levels_db = [default.sensation.sensation_db(signal, touch) for touch in TOUCHES]
        assert levels_db == pytest.approx([alike.sensation(signal, touch) for touch in TOUCHES], abs=1e-9)


def test_extra_effects_of_scenes_are_listed_with_changes():
    (told,) = felt_effects(wired("time-reversal-threshold"))
    changes = {one.effect: one.change_db for one in told.left_out}
    cell = next(iter(wired("time-reversal-threshold", '\n[scene]\nname = "a4-screen"\n').cells.values()))
    assert cell.sensation.scene.find("load") is not None
    assert changes["finger_load"] < -0.5


def test_panel_tone_equals_played_voltage():
    file = load_scene(path_of("electrovibration-panel"))
    tone = AmplitudeModulated(240.0, duration_s=0.2, ramp_s=0.02, carrier_hz=2e3)
    played_db = default_scene(ElectrovibrationSensation(), 0.2).sensation(tone.at(30.0), TOUCHES[0])
    assert file.scene.resolve().run(file.given)["sensation_db"] == pytest.approx(played_db, abs=0.01)


def test_screen_focus_equals_played_drive():
    """Analogue output, as quantization would change the level by 0.1 dB."""
    file, touch = load_scene(path_of("a4-screen")), Contact(2.0)
    scene = replace(file.scene, outputs=("sensation_db",))
    learnt = without(scene, {"audible_filter", "airborne_sound", "drive_energy", "one_bit"})
    setup = Setup(modes_to_hz=100e3)
    train = FocusTrain(setup, f_max_hz=60e3, drive="analogue")
    signal = train.at(20 * np.log10(file.given["voltage_v"] / train.voltage_v(0.0)))
    for criterion, kinds in (("loaded", set()), ("unloaded", {"finger_load"})):
        played = default_scene(TimeReversalSensation(setup, criterion=criterion))
        found_db = without(learnt, kinds).resolve().run(file.given)["sensation_db"]
        assert found_db == pytest.approx(played.sensation(signal, touch), abs=20 * np.log10(1 + scene.accuracy))
