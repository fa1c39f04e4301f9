"""Errors of a scene against the same scene computed finer."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np
from scene_cases import VOLT, effect, finest_of, refusal

from tactometry.stimuli.scenes.scene import Scene

LOSSY = effect("attenuation", tau_s=2e-3)


def run(scene: Scene):
    plan = scene.resolve()
    return plan.run({name: VOLT[name] for name in plan.given})


def error_of(got, reference, output):
    """Relative to the peak: of a course and a map by straight lines between what is given, of a level as a ratio."""
    if output.endswith(("_db", "_dba")):
        return abs(10 ** ((got[output] - reference[output]) / 20) - 1)
    if output == "field_m":
        return _map_error(got, reference)
    if np.ndim(got[output]) == 0:
        return abs(got[output] / reference[output] - 1)
    courses, true = np.atleast_2d(got[output]), np.atleast_2d(reference[output])
    lines = [np.interp(reference["t_s"], got["t_s"], course) for course in courses]
    return float(np.abs(lines - true).max() / np.abs(true).max())


def finer(scene: Scene) -> Scene:
    """A reference: the finest of these that is not refused, at the nodes of a coarse map."""
    fine = finest_of(scene, 2e-5, 4e-5, 1e-4)
    plan = fine.resolve()
    chosen = {stage.name: dict(stage.settings) for stage in plan.stages}
    motion = chosen.get("motion", {})
    override = {key: 1.4 * motion[key] for key in ("modes_to_hz", "heard_to_hz") if key in motion}
    override |= {"static_to_hz": max(override["modes_to_hz"], motion["static_to_hz"])} if override else {}
    settings = {"motion": override, "grid_x": {"n": 157}, "grid_y": {"n": 113}}
    return replace(fine, settings={name: settings[name] for name in settings if name in chosen})


def _map_error(got, reference):
    from scipy.interpolate import RegularGridInterpolator

    lines = RegularGridInterpolator((got["x_m"], got["y_m"]), got["field_m"])
    places = np.stack(np.meshgrid(reference["x_m"], reference["y_m"], indexing="ij"), axis=-1)
    return float(np.abs(lines(places) - reference["field_m"]).max() / np.abs(reference["field_m"]).max())


def accepted(scene: Scene, accuracies: Iterable[float]) -> Iterator[Scene]:
    """Yield the scene at each accuracy that it accepts. It may refuse those below 1e-3, with the remedy."""
    for accuracy in accuracies:
        requested = replace(scene, accuracy=accuracy)
        if reason := refusal(requested):
            assert accuracy < 1e-3, reason
            assert "loosen the accuracy" in reason
        else:
            yield requested
