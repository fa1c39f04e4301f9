"""Surfaces, one file each, by the name that a scene file gives them."""

from collections.abc import Mapping

from ...composition.effect import note

SURFACES: Mapping[str, str] = {
    "electrovibration": "tactometry.stimuli.scenes.surfaces.electrovibration:Electrovibration",
    "time_reversal": "tactometry.stimuli.scenes.surfaces.time_reversal:TimeReversal",
    "hybrid": "tactometry.stimuli.scenes.surfaces.hybrid:HybridScreen",
}

REFUSES: Mapping[str, str] = note(
    "'focus_detection' in its place: a focus is felt as one event, whose spectrum in the skin no source states, and a "
    "train of them by the Pacinian channel alone",
    "receptors",
    "sensitivity",
    "summation",
)
"""Thresholds by frequency, which a plate that focuses refuses."""
