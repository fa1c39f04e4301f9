"""Each effect of a time-reversal scene keeps the accuracy that is asked for."""

from dataclasses import replace

import pytest
from scene_cases import screen, tuned
from test_scene_time_reversal import LOSSY, error_of, finer, run

OUTPUTS = {
    "foci": ("peaks_m",),
    "repetition": ("t_s", "focus_displacement_m"),
    "temperature_drift": ("t_s", "focus_displacement_m"),
    "amplifier": ("t_s", "focus_displacement_m"),
    "shear": ("t_s", "focus_displacement_m"),
}


def error_of_peaks(got, reference, output):
    return abs(got[output] - reference[output]).max() / abs(reference[output]).max()


@pytest.mark.parametrize("kind", sorted(OUTPUTS))
def test_an_effect_keeps_the_accuracy(kind):
    scene = screen(LOSSY, *tuned(kind), outputs=OUTPUTS[kind])
    error = error_of_peaks if kind == "foci" else error_of
    reference = run(finer(scene))
    for accuracy in (1e-2, 1e-3, 1e-4):
        asked = replace(scene, accuracy=accuracy)
        assert kind in {stage.effect for stage in asked.resolve().stages}
        assert error(run(asked), reference, OUTPUTS[kind][-1]) <= asked.resolve().error <= accuracy
