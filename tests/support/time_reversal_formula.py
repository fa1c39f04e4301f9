"""The level of foci by one formula, straight from the laws: what the scene of their model computes."""

from functools import lru_cache
from math import inf, log10

from tactometry.stimuli.time_reversal.focusing.focusing import emitted
from tactometry.stimuli.time_reversal.stimulus.sensation import (
    TimeReversalSensation,
    events,
    felt_amplitude_m,
    loaded_displacements,
)


def level_db(model, signal, contact):
    """Sensation level (dB) by a `TimeReversalSensation`."""
    if contact.force_n == 0 or signal.peak == 0:
        return -inf
    x_m, y_m = model.setup.focus_m
    at_m = x_m if model.finger_x_m is None else model.finger_x_m, y_m if model.finger_y_m is None else model.finger_y_m
    if model.criterion == "unloaded":
        felt_m = _felt_m(signal, model.setup, at_m)
    else:
        load = model.finger.load(at_m, contact.force_n)
        (loaded_m,) = loaded_displacements(_free_m(signal, model.setup, at_m)[None], model.setup, [load])
        felt_m = felt_amplitude_m(*events(loaded_m, signal.rate_hz))
    return 20 * log10(felt_m / model.reference_m)


@lru_cache(maxsize=32)
def _free_m(signal, setup, at_m):
    return emitted(signal, setup.responses_at(*at_m))[0]


@lru_cache(maxsize=32)
def _felt_m(signal, setup, at_m):
    return felt_amplitude_m(*events(_free_m(signal, setup, at_m), signal.rate_hz))


def strongest_db(model, signal, contact):
    """Sensation level (dB) by a `FingersSensation`: that of the finger that feels most."""
    places_m = (model.places[name].on(model.setup) for name in model.fingers or model.places)
    alone = (TimeReversalSensation(model.setup, model.reference_m, finger_x_m=x, finger_y_m=y) for x, y in places_m)
    return max(level_db(finger, signal, contact) for finger in alone)
