"""Ladders: what accuracy costs. One file each, one line here."""

from collections.abc import Mapping

LADDERS: Mapping[str, str] = {
    "plate-modes-simply-supported": "tactometry.experiments.ladders.plate_modes:simply_supported",
    "plate-modes-free": "tactometry.experiments.ladders.plate_modes:free",
    "field-grid": "tactometry.experiments.ladders.field_grid:problem",
    "skin-propagator": "tactometry.experiments.ladders.skin_propagator:problem",
    "friction-events": "tactometry.experiments.ladders.friction_events:problem",
    "sigma-delta-1": "tactometry.experiments.ladders.sigma_delta:first_order",
    "sigma-delta-2": "tactometry.experiments.ladders.sigma_delta:second_order",
    "quest-plus-grid": "tactometry.experiments.ladders.quest_plus_grid:problem",
    "reversal-time": "tactometry.experiments.ladders.reversal_time:problem",
    "scene-electrovibration-panel": "tactometry.experiments.ladders.scene_panel:problem",
}
"""The name of each ladder, and the function that gives its problem."""
