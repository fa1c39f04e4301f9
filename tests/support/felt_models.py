"""What is felt of a model of `[sensation]`, through its default scene."""

from functools import lru_cache

from tactometry.experiments.study.felt_scene import FeltScene, felt
from tactometry.stimuli.electrovibration.sensation import ElectrovibrationSensation
from tactometry.stimuli.hybrid import HybridSensation
from tactometry.stimuli.scenes.defaults import electrovibration, hybrid, time_reversal
from tactometry.stimuli.time_reversal.stimulus.sensation import TimeReversalSensation

DEFAULTS = {
    ElectrovibrationSensation: electrovibration.default_scene,
    TimeReversalSensation: time_reversal.default_scene,
    HybridSensation: hybrid.default_scene,
}


@lru_cache(maxsize=16)
def felt_by(model: object) -> FeltScene:
    """The skin of a participant with this model."""
    return felt(DEFAULTS[type(model)](model))
