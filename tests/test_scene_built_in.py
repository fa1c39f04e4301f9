"""The built-in scenes of time reversal keep the accuracy that is asked for, output by output."""

import os
from dataclasses import replace

import pytest
from scene_cases import refusal
from test_scene_time_reversal import error_of

from tactometry.experiments.scenes import path_of
from tactometry.stimuli.scenes.file import load_scene

SOAK = os.environ.get("TACTOMETRY_SOAK") == "1"
ACCURACIES, FINEST = ((1e-1, 1e-2, 1e-3, 1e-4), 4e-5) if SOAK else ((1e-1, 1e-2), 1e-3)
CASES = [
    ("a4-screen", ("t_s", "focus_displacement_m", "contact_force_n", "sensation_db", "peak_m")),
    ("a4-screen", ("sound_level_dba", "energy_j")),
    ("a4-screen", ("x_m", "y_m", "field_m")),
    ("thin-screen", ("t_s", "focus_displacement_m", "peak_m")),
    ("thin-screen", ("sound_level_dba",)),
    ("thin-screen", ("x_m", "y_m", "field_m")),
]
CASES += [("hybrid-screen", ("t_s", "focus_displacement_m", "contact_force_n"))] if SOAK else []
BESIDE = frozenset(("t_s", "x_m", "y_m"))


def reference(scene, run):
    """The finest run that is not refused, on a coarse map."""
    accuracy = next(value for value in (FINEST, 1e-4, 5e-4) if not refusal(replace(scene, accuracy=value)))
    given = {stage.name for stage in scene.resolve().stages}
    grids = {name: {"n": n} for name, n in (("grid_x", 157), ("grid_y", 113)) if name in given}
    return run(replace(scene, accuracy=accuracy, settings=grids)), accuracy


@pytest.mark.parametrize(("name", "outputs"), CASES)
def test_a_built_in_scene_keeps_the_accuracy_of_every_output_or_refuses_it_with_the_reason(name, outputs):
    found = load_scene(path_of(name))
    scene = replace(found.scene, outputs=outputs)

    def run(one):
        plan = one.resolve()
        return plan.run({key: found.given[key] for key in plan.given})

    true, finest = reference(scene, run)
    for accuracy in (value for value in ACCURACIES if value > finest):
        reason = refusal(replace(scene, accuracy=accuracy))
        if reason:
            assert accuracy < 1e-3, reason
            assert "loosen the accuracy" in reason
            continue
        plan = replace(scene, accuracy=accuracy).resolve()
        got = plan.run({key: found.given[key] for key in plan.given})
        for output in set(outputs) - BESIDE:
            assert error_of(got, true, output) <= plan.error + finest <= accuracy + finest
