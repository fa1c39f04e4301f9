"""Accuracy problems of `tactometry cost`.

Each problem is a function in `problems` and has one line in this file.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from tactometry.loading import resolve

if TYPE_CHECKING:
    from .measure import Problem

_HERE = "tactometry.experiments.accuracy.problems"
PROBLEMS: Mapping[str, str] = {
    "plate-modes-simply-supported": f"{_HERE}.plates:simply_supported",
    "plate-modes-free": f"{_HERE}.plates:free",
    "boundary-basis": f"{_HERE}.plates:mixed_edges",
    "field-grid": f"{_HERE}.plates:field_grid",
    "pulp-impedance": f"{_HERE}.plates:pulp_impedance",
    "time-integration": f"{_HERE}.plate_motion:time_integration",
    "finger-load": f"{_HERE}.plate_motion:finger_load",
    "lift-off": f"{_HERE}.plate_motion:lift_off",
    "drive-oversampling": f"{_HERE}.drives:oversampling",
    "sigma-delta-1": f"{_HERE}.drives:first_order",
    "sigma-delta-2": f"{_HERE}.drives:second_order",
    "reversal-time-amplitude": f"{_HERE}.drives:reversal_amplitude",
    "reversal-time-contrast": f"{_HERE}.drives:reversal_contrast",
    "spectral-sensitivity": f"{_HERE}.perception:sensitivity",
    "receptor-filter-bank": f"{_HERE}.perception:filter_bank",
    "skin-propagator": f"{_HERE}.electrovibration:skin_propagator",
    "friction-events": f"{_HERE}.electrovibration:friction_events",
    "threshold-fit": f"{_HERE}.posteriors:threshold_fit",
    "hierarchical-fit": f"{_HERE}.posteriors:hierarchical_fit",
    "quest-plus-grid": f"{_HERE}.posteriors:quest_plus_grid",
    "procedures": f"{_HERE}.procedures:problem",
    "group-threshold": f"{_HERE}.procedures:group_threshold",
    "scene-a4-screen": f"{_HERE}.scenes:a4_screen",
    "scene-thin-screen": f"{_HERE}.scenes:thin_screen",
    "scene-hybrid-screen": f"{_HERE}.scenes:hybrid_screen",
    "scene-electrovibration-panel": f"{_HERE}.scenes:panel",
}
"""Functions that return the problems, by problem name."""


def problem_of(name: str) -> "Problem":
    """Return a problem by its name."""
    problem: Problem = resolve(PROBLEMS[name])()
    return replace(problem, name=name)
