"""Foci under a finger that rests."""

from collections.abc import Iterator

from ...composition.effect import Effect
from ...time_reversal.stimulus.sensation import TimeReversalSensation
from ..scene import SENSATION, Scene
from ..surfaces.played_time_reversal import PlayedTimeReversal
from . import ACCURACY, effect


def default_scene(model: TimeReversalSensation, duration_s: float = 1.0) -> Scene:
    """The scene of a model; no spectrum is read, however long its drives last.

    >>> [effect.kind for effect in default_scene(TimeReversalSensation(criterion="loaded")).effects]
    ['finger_load', 'focus_detection']
    """
    surface = PlayedTimeReversal(model.setup, model.finger_x_m, model.finger_y_m, model.finger)
    return Scene(surface, tuple(effects(model)), (SENSATION,), ACCURACY, surface.touches)


def effects(model: TimeReversalSensation) -> Iterator[Effect]:
    """Those of a model."""
    pulp = model.resistance_n_s_per_m, model.mass_kg, model.stiffness_n_per_m
    if model.criterion == "loaded" and any(pulp):
        yield effect("finger_load", *pulp, model.exponent)
    yield effect("focus_detection", model.reference_m)
