"""The friction that a voltage causes under a finger that slides."""

from collections.abc import Iterator
from dataclasses import replace
from math import inf
from typing import Final

from tactometry.arguments.require import expect

from ...composition.effect import Effect
from ...electrovibration.sensation import ElectrovibrationSensation
from ...electrovibration.skin.skin import Skin
from ...perception.channels import BEST_HZ
from ..scene import SENSATION, Scene
from ..surfaces.played_electrovibration import PlayedElectrovibration
from . import ACCURACY, effect

WITHOUT_LEAK: Final = ("parallel_plate", "total_thickness")
"""Laws that have no term for what leaks."""


def default_scene(model: ElectrovibrationSensation, duration_s: float = 1.0) -> Scene:
    """The scene of a model, under voltages that last so long.

    Raises
    ------
    InvalidParameter
        If the area law is none that scenes have.

    >>> [effect.kind for effect in default_scene(ElectrovibrationSensation()).effects]
    ['skin_leakage', 'contact_area', 'force_law', 'friction', 'friction_lag', 'skin_mobility', 'sensitivity']
    """
    surface = PlayedElectrovibration(layers(model.skin), duration_s=duration_s)
    return Scene(surface, tuple(effects(model)), (SENSATION,), ACCURACY, surface.touches)


def layers(skin: Skin) -> Skin:
    """What of a skin is no effect."""
    resistivity_ohm_m = inf if skin.corneum_resistivity_ohm_m else 0.0
    return replace(skin, corneum_resistivity_ohm_m=resistivity_ohm_m, gap_m=0.0, body_resistance_ohm=0.0)


def effects(model: ElectrovibrationSensation) -> Iterator[Effect]:
    """Those of a model, in the order in which they act."""
    skin, area = model.skin, model.area
    if skin.body_resistance_ohm:
        yield effect("body_resistance", skin.body_resistance_ohm)
    if 0 < skin.corneum_resistivity_ohm_m < inf and model.law not in WITHOUT_LEAK:
        yield effect("skin_leakage", skin.corneum_resistivity_ohm_m)
    if skin.gap_m:
        yield effect("air_gap", skin.gap_m)
    is_effect = isinstance(area, Effect)
    expect(is_effect, "ElectrovibrationSensation.area", type(area).__name__, "a PowerLawArea or a TableArea")
    yield from (law for law in (area,) if isinstance(law, Effect))
    yield effect("force_law", model.law)
    yield from (one for one in (model.polarity, model.friction, model.lag) if one is not None)
    if model.criterion == "fraction":
        yield effect("weber_fraction")
    yield model.mobility
    yield effect("sensitivity", _threshold_m(model))


def _threshold_m(model: ElectrovibrationSensation) -> float:
    """Displacement of the skin at threshold, at 250 Hz under 1 N."""
    if model.reference_force_n is None:
        return model.reference_m
    return model.reference_force_n * float(model.mobility.gain_m_per_n(BEST_HZ, force_n=1.0))
