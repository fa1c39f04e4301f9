"""Sensations of a model of `[sensation]` in its default scene."""

from functools import lru_cache

from tactometry.experiments.study.felt_scene import FeltScene, felt
from tactometry.stimuli.scenes.default_scenes import default_scene


@lru_cache(maxsize=16)
def felt_by(model: object) -> FeltScene:
    return felt(default_scene(model))
