"""Ladders: what accuracy costs. One file each, one line here."""

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from tactometry.loading import resolve

if TYPE_CHECKING:
    from ..cost.problem import Problem

_HERE = "tactometry.experiments.ladders"
LADDERS: Mapping[str, str] = {
    "plate-modes-simply-supported": f"{_HERE}.plate_modes:simply_supported",
    "plate-modes-free": f"{_HERE}.plate_modes:free",
    "boundary-basis": f"{_HERE}.boundary_basis:problem",
    "field-grid": f"{_HERE}.field_grid:problem",
    "time-integration": f"{_HERE}.time_integration:problem",
    "finger-load": f"{_HERE}.finger_load:problem",
    "lift-off": f"{_HERE}.lift_off:problem",
    "drive-oversampling": f"{_HERE}.drive_oversampling:problem",
    "sigma-delta-1": f"{_HERE}.sigma_delta:first_order",
    "sigma-delta-2": f"{_HERE}.sigma_delta:second_order",
    "reversal-time-amplitude": f"{_HERE}.reversal_time:amplitude",
    "reversal-time-contrast": f"{_HERE}.reversal_time:contrast",
    "spectral-sensitivity": f"{_HERE}.perception:sensitivity",
    "receptor-filter-bank": f"{_HERE}.perception:filter_bank",
    "skin-propagator": f"{_HERE}.skin_propagator:problem",
    "friction-events": f"{_HERE}.friction_events:problem",
    "threshold-fit": f"{_HERE}.threshold_fit:problem",
    "hierarchical-fit": f"{_HERE}.hierarchical_fit:problem",
    "quest-plus-grid": f"{_HERE}.quest_plus_grid:problem",
    "procedures": f"{_HERE}.procedures:problem",
    "group-threshold": f"{_HERE}.group_threshold:problem",
    "scene-a4-screen": f"{_HERE}.scenes:a4_screen",
    "scene-thin-screen": f"{_HERE}.scenes:thin_screen",
    "scene-hybrid-screen": f"{_HERE}.scenes:hybrid_screen",
    "scene-electrovibration-panel": f"{_HERE}.scenes:panel",
}
"""The name of each ladder, and the function that gives its problem."""


def problem_of(ladder: str) -> "Problem":
    """The problem of a ladder, by its name."""
    problem: Problem = resolve(LADDERS[ladder])()
    return replace(problem, name=ladder)
