"""Foci and friction at once."""

from ...hybrid import HybridSensation
from ...time_reversal.stimulus.sensation import TimeReversalSensation
from ..scene import SENSATION, Scene
from ..surfaces.played_electrovibration import PlayedElectrovibration
from ..surfaces.played_hybrid import PlayedHybrid
from ..surfaces.played_time_reversal import PlayedTimeReversal
from . import ACCURACY, electrovibration, time_reversal


def default_scene(model: HybridSensation, duration_s: float = 1.0) -> Scene:
    """The scene of a model, under drives that last so long.

    >>> [effect.kind for effect in default_scene(HybridSensation()).effects][:2]
    ['focus_detection', 'skin_leakage']
    """
    foci = TimeReversalSensation(model.setup, model.reference_m)
    panel = PlayedElectrovibration(electrovibration.layers(model.friction.skin), duration_s=duration_s)
    surface = PlayedHybrid(panel, PlayedTimeReversal(model.setup))
    effects = (*time_reversal.effects(foci), *electrovibration.effects(model.friction))
    return Scene(surface, effects, (SENSATION,), ACCURACY, surface.touches)
