"""Default scenes of sensation for studies that state none."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import chain
from math import inf
from typing import TYPE_CHECKING, Any, Final

from tactometry.arguments.require import expect
from tactometry.loading import resolve

from ..composition.effect import Effect
from .effects import EFFECTS
from .scene import SENSATION, Scene

if TYPE_CHECKING:
    from ..composition.effect import Surface
    from ..electrovibration.sensation import ElectrovibrationSensation
    from ..time_reversal.stimulus.sensation import TimeReversalSensation
    from .surfaces.electrovibration import PlayedElectrovibration

ACCURACY: Final = 0.02
"""Half of it allows for aliasing, 40 dB below the signal, and half for the spectrum."""

WITHOUT_LEAK: Final = ("parallel_plate", "total_thickness")
"""Force laws without a term for a leaking corneum."""


def default_scene(model: Any, duration_s: float = 1.0) -> Scene:
    """Build the scene of a `[sensation]` model.

    Raises `InvalidParameter` if scenes do not support the area law.

    Parameters
    ----------
    model : ElectrovibrationSensation, TimeReversalSensation, FingersSensation or HybridSensation
    duration_s : float
        Duration of the voltages; not used for drives of a plate.

    >>> from tactometry.stimuli.electrovibration.sensation import ElectrovibrationSensation
    >>> [effect.kind for effect in default_scene(ElectrovibrationSensation()).effects]
    ['skin_leakage', 'contact_area', 'force_law', 'friction', 'friction_lag', 'skin_mobility', 'sensitivity']

    >>> from tactometry.stimuli.time_reversal.stimulus.sensation import TimeReversalSensation
    >>> [effect.kind for effect in default_scene(TimeReversalSensation(criterion="loaded")).effects]
    ['finger_load', 'focus_detection']

    >>> from tactometry.contact import Contact
    >>> from tactometry.stimuli.time_reversal.stimulus.placed_foci import FingersSensation, Place, PlacedFoci
    >>> from tactometry.stimuli.time_reversal.stimulus.setup import Setup
    >>> setup = Setup(n_transducers=8, modes_to_hz=22e3, rate_hz=50e3)
    >>> places = {"index": Place(0.10), "middle": Place(0.13)}
    >>> signal = PlacedFoci(setup, f_max_hz=20e3, places=places, place="index").at(20.0)
    >>> index_db, middle_db = default_scene(FingersSensation(setup, places)).fingers_db(signal, Contact(1.0))
    >>> abs(round(index_db, 2)), middle_db < -3
    (0.0, True)
    """
    surface, effects = _parts(model, duration_s)
    return Scene(surface, tuple(effects), (SENSATION,), ACCURACY, surface.touches)


def _parts(model: Any, duration_s: float) -> "tuple[Surface, Iterator[Effect]]":
    kind = type(model).__name__
    if kind == "ElectrovibrationSensation":
        return _panel(model, duration_s), _friction_effects(model)

    from .surfaces.played_plates import PlayedFingers, PlayedHybrid, PlayedTimeReversal

    if kind == "TimeReversalSensation":
        surface = PlayedTimeReversal(model.setup, model.finger_x_m, model.finger_y_m, model.finger)
        return surface, _focus_effects(model)
    if kind == "FingersSensation":
        fingers = PlayedFingers(model.setup, model.places, model.fingers)
        return fingers, iter((_effect("focus_detection", model.reference_m),))

    from ..time_reversal.stimulus.sensation import TimeReversalSensation

    foci = TimeReversalSensation(model.setup, model.reference_m)
    both = PlayedHybrid(_panel(model.friction, duration_s), PlayedTimeReversal(model.setup))
    return both, chain(_focus_effects(foci), _friction_effects(model.friction))


def _panel(model: "ElectrovibrationSensation", duration_s: float) -> "PlayedElectrovibration":
    from .surfaces.electrovibration import PlayedElectrovibration

    # leakage, air gap and body resistance are effects
    resistivity_ohm_m = inf if model.skin.corneum_resistivity_ohm_m else 0.0
    skin = replace(model.skin, corneum_resistivity_ohm_m=resistivity_ohm_m, gap_m=0.0, body_resistance_ohm=0.0)
    return PlayedElectrovibration(skin, duration_s=duration_s)


def _friction_effects(model: "ElectrovibrationSensation") -> Iterator[Effect]:
    from ..perception.channels import BEST_HZ

    skin, area = model.skin, model.area
    if skin.body_resistance_ohm:
        yield _effect("body_resistance", skin.body_resistance_ohm)
    if 0 < skin.corneum_resistivity_ohm_m < inf and model.law not in WITHOUT_LEAK:
        yield _effect("skin_leakage", skin.corneum_resistivity_ohm_m)
    if skin.gap_m:
        yield _effect("air_gap", skin.gap_m)

    is_effect = isinstance(area, Effect)
    expect(is_effect, "ElectrovibrationSensation.area", type(area).__name__, "a PowerLawArea or a TableArea")
    yield from (law for law in (area,) if isinstance(law, Effect))
    yield _effect("force_law", model.law)
    yield from (one for one in (model.polarity, model.friction, model.lag) if one is not None)
    if model.criterion == "fraction":
        yield _effect("weber_fraction")
    yield model.mobility

    threshold_m = model.reference_m
    if model.reference_force_n is not None:
        threshold_m = model.reference_force_n * float(model.mobility.gain_m_per_n(BEST_HZ, force_n=1.0))
    yield _effect("sensitivity", threshold_m)


def _focus_effects(model: "TimeReversalSensation") -> Iterator[Effect]:
    pulp = model.resistance_n_s_per_m, model.mass_kg, model.stiffness_n_per_m
    if model.criterion == "loaded" and any(pulp):
        yield _effect("finger_load", *pulp, model.exponent)
    yield _effect("focus_detection", model.reference_m)


def _effect(kind: str, *values: Any) -> Effect:
    made: Effect = resolve(EFFECTS[kind])(*values)
    return made
