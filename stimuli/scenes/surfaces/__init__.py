"""Surfaces, one file each, by the name that a scene file gives them."""

from collections.abc import Mapping

SURFACES: Mapping[str, str] = {
    "electrovibration": "tactometry.stimuli.scenes.surfaces.electrovibration:Electrovibration",
    "time_reversal": "tactometry.stimuli.scenes.surfaces.time_reversal:TimeReversal",
    "hybrid": "tactometry.stimuli.scenes.surfaces.hybrid:HybridScreen",
}
