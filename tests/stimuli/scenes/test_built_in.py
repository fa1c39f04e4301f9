"""Accuracy and cost of every output of the built-in scenes."""

from dataclasses import replace

import pytest
from scene_cases import RUBBED, refusal
from scene_errors import accepted, error_of
from soak import SOAK

from tactometry.experiments.scenes import path_of
from tactometry.stimuli.scenes.file import load_scene

ACCURACIES = (1e-1, 1e-2, 1e-3, 1e-4) if SOAK else (1e-1, 1e-2)
FINEST = (4e-5, 6e-5, 9e-5, 5e-4) if SOAK else (1e-3,)
FOCUS = ("t_s", "focus_displacement_m", "contact_force_n", "peak_m", "sensation_db")
MAP, LEVELS = ("x_m", "y_m", "field_m"), ("sound_level_dba", "energy_j")
CASES = [
    ("a4-screen", FOCUS),
    ("a4-screen", LEVELS),
    ("a4-screen", MAP),
    ("thin-screen", ("t_s", "focus_displacement_m", "peak_m")),
    ("thin-screen", LEVELS),
    ("thin-screen", MAP),
    ("electrovibration-panel", ("t_s", "voltage_v", *RUBBED)),
    ("electrovibration-panel", ("sensation_db",)),
    pytest.param("hybrid-screen", FOCUS, marks=pytest.mark.slow),
    ("hybrid-screen", ("sliding_t_s", *RUBBED, "sliding_sensation_db")),
]
CLOCKS = frozenset(("t_s", "sliding_t_s", "x_m", "y_m"))
READ_OFF = frozenset(("focus_displacement_m", "field_m", "electrostatic_force_n"))
"""Courses and maps, whose error is that of straight lines; levels, peaks and energies are far better than predicted."""


def ran(found, scene):
    plan = scene.resolve()
    return plan.run({key: found.given[key] for key in plan.given}), plan.error


def reference(scene):
    """Return the most accurate accepted scene, on a coarse map."""
    fine = next(finer for finer in (replace(scene, accuracy=value) for value in FINEST) if not refusal(finer))
    stages = {stage.name for stage in fine.resolve().stages}
    return replace(fine, settings={name: {"n": n} for name, n in (("grid_x", 157), ("grid_y", 113)) if name in stages})


def error(got, true, output):
    """Return the error on the output's own clock."""
    clock = "sliding_t_s" if output in RUBBED and "sliding_t_s" in got else "t_s"
    return error_of({**got, "t_s": got.get(clock)}, {**true, "t_s": true.get(clock)}, output)


@pytest.mark.parametrize(("name", "outputs"), CASES)
def test_built_in_scene_meets_accuracy_or_is_refused(name, outputs):
    """The predicted error never exceeds the requested accuracy.

    It is at most ten times the true error, or a tenth of the request if that is larger.
    """
    found = load_scene(path_of(name))
    finest = reference(replace(found.scene, outputs=outputs))
    true, _ = ran(found, finest)
    scene = replace(found.scene, outputs=outputs)
    for requested in accepted(scene, (value for value in ACCURACIES if value > finest.accuracy)):
        got, predicted = ran(found, requested)
        errors = {output: error(got, true, output) for output in outputs if output not in CLOCKS}
        assert max(errors.values()) <= predicted + finest.accuracy
        assert predicted <= requested.accuracy
        if READ_OFF & set(errors):
            assert predicted <= 10 * (max(errors.values()) + finest.accuracy)
