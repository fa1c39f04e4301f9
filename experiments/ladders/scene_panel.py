"""The built-in scene `electrovibration-panel` as a whole, against the accuracy that is asked of it."""

from dataclasses import replace
from functools import partial

import numpy as np

from tactometry.stimuli.electrovibration import (
    AmplitudeModulated,
    PowerLawArea,
    Skin,
    electrostatic_force_n,
    electrostatic_force_n_at,
)
from tactometry.stimuli.scenes.file import SceneFile, load_scene

from ..cost.problem import Problem, Real, Rung
from ..scenes import path_of

ACCURACIES = (1e-1, 1e-2, 1e-3, 1e-4)
OUTPUTS = ("t_s", "electrostatic_force_n")
N_TIMES, STEPS_BETWEEN = 8001, 40
Course = tuple[Real, Real]


def problem() -> Problem:
    """The electrostatic force, straight between the samples, over its peak."""
    scene = load_scene(path_of("electrovibration-panel"))
    return Problem(
        "largest error of the electrostatic force over its peak, for the accuracy asked for",
        "the exact solution in pieces",
        "recurrence on fine samples",
        reference=lambda: (_exact(scene), 1e-12),
        independent=lambda: (_stepped(scene), 1e-4),
        error=_error,
        rungs=tuple(Rung(f"accuracy {accuracy:g}", partial(_run, scene, accuracy)) for accuracy in ACCURACIES),
    )


def _run(scene: SceneFile, accuracy: float) -> Course:
    values = replace(scene.scene, outputs=OUTPUTS, accuracy=accuracy).resolve().run(scene.given)
    return values["t_s"], values["electrostatic_force_n"]


def _error(found: Course, reference: Course) -> float:
    lines = np.interp(reference[0], *found)
    return float(np.abs(lines - reference[1]).max() / reference[1].max())


def _exact(scene: SceneFile) -> Course:
    tone, t_s = _tone(20e3), np.linspace(0, 0.2, N_TIMES)
    pieces = tone.pieces(scene.given["level_db_re_1v"])
    return t_s, electrostatic_force_n_at(t_s, pieces, skin=Skin(), area_m2=_area_m2(), law="sc_layer")


def _stepped(scene: SceneFile) -> Course:
    """Fine samples of the voltage, and the recurrence of the circuit."""
    rate_hz = (N_TIMES - 1) / 0.2 * STEPS_BETWEEN
    voltage_v = _tone(rate_hz).at(scene.given["level_db_re_1v"]).samples[0]
    force_n = electrostatic_force_n(voltage_v, rate_hz=rate_hz, skin=Skin(), area_m2=_area_m2(), law="sc_layer")
    return np.arange(N_TIMES - 1) * STEPS_BETWEEN / rate_hz, force_n[::STEPS_BETWEEN]


def _tone(rate_hz: float) -> AmplitudeModulated:
    return AmplitudeModulated(240.0, 2_000.0, 0.2, 0.02, rate_hz)


def _area_m2() -> float:
    return float(PowerLawArea().area_m2(1.5))
