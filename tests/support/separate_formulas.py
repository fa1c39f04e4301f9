"""Levels of signals by one formula for each surface, straight from the laws: what the scenes of the models compute.

Nothing here knows a stage or an effect: the order of the laws is written out once more, and nothing is chosen.
"""

from functools import lru_cache, singledispatch
from math import inf, log10

import numpy as np

from tactometry.contact import Contact
from tactometry.signal import Signal
from tactometry.stimuli.electrovibration.attraction.force import electrostatic_force_n
from tactometry.stimuli.electrovibration.sensation import ElectrovibrationSensation
from tactometry.stimuli.hybrid import HybridSensation
from tactometry.stimuli.perception.channels import as_at_250_hz
from tactometry.stimuli.perception.detection import components
from tactometry.stimuli.time_reversal.focusing.focusing import emitted
from tactometry.stimuli.time_reversal.stimulus.placed_foci import FingersSensation
from tactometry.stimuli.time_reversal.stimulus.sensation import (
    TimeReversalSensation,
    events,
    felt_amplitude_m,
    loaded_displacements,
)

HIGH_SHARE = 1e-4
"""Of the power: below it, what aliases is 40 dB under the rest."""


@singledispatch
def level_db(model, signal: Signal, contact: Contact) -> float:
    """Sensation level (dB) of a signal under a finger."""
    raise TypeError(type(model))


@level_db.register
def _(model: ElectrovibrationSensation, signal, contact):
    force_n, speed_m_per_s = contact.force_n, contact.speed_m_per_s
    if not (force_n and speed_m_per_s):
        return -inf
    area_m2 = float(model.area.area_m2(force_n))
    in_series = model.skin.body_resistance_ohm > 0  # without, the area is only a factor
    parts = _attraction(signal, model.skin, area_m2 if in_series else 1.0, model.law, model.polarity)
    amplitudes = model.friction.at_speed(speed_m_per_s).modulation_n(parts.amplitudes, force_n)
    amplitudes = amplitudes * (1.0 if in_series else area_m2)
    if model.lag is not None:
        amplitudes = amplitudes * model.lag.gain(parts.frequencies_hz, speed_m_per_s)
    largest_m = (amplitudes * model.mobility.gain_m_per_n(parts.frequencies_hz, force_n)).max(initial=0.0)
    reference_m = model.reference_m * (force_n if model.criterion == "fraction" else 1.0)
    return 20 * log10(largest_m / reference_m) if largest_m else -inf


@lru_cache(maxsize=512)
def _attraction(signal, skin, area_m2, law, polarity):
    """Components of the force, of which those are left that touch hears, as strong as they are felt."""
    voltage_v, rate_hz = with_room_for_the_square(signal.samples[0], signal.rate_hz)
    force_n = electrostatic_force_n(voltage_v, rate_hz=rate_hz, skin=skin, area_m2=area_m2, law=law, polarity=polarity)
    return as_at_250_hz(components(force_n, rate_hz))


def with_room_for_the_square(voltage_v, rate_hz):
    """Samples and rate; twice as many (band-limited) if there is power above a quarter of the rate."""
    lines, n = np.fft.rfft(voltage_v), voltage_v.size
    power = lines.real**2 + lines.imag**2
    if n < 4 or power[lines.size // 2 :].sum() <= HIGH_SHARE * power.sum():
        return voltage_v, rate_hz
    lines[n // 2 :] *= 1.0 if n % 2 else 0.5
    return 2 * np.fft.irfft(lines, n=2 * n), 2 * rate_hz


@level_db.register
def _(model: TimeReversalSensation, signal, contact):
    if contact.force_n == 0 or signal.peak == 0:
        return -inf
    x_m, y_m = model.setup.focus_m
    at_m = x_m if model.finger_x_m is None else model.finger_x_m, y_m if model.finger_y_m is None else model.finger_y_m
    if model.criterion == "unloaded":
        felt_m = _felt_m(signal, model.setup, at_m)
    else:
        load = model.finger.load(at_m, contact.force_n)
        loaded_m = loaded_displacements(_free_m(signal, model.setup, at_m)[None], model.setup, [load])[0]
        felt_m = felt_amplitude_m(*events(loaded_m, signal.rate_hz))
    return 20 * log10(felt_m / model.reference_m)


@lru_cache(maxsize=32)
def _free_m(signal, setup, at_m):
    return emitted(signal, setup.responses_at(*at_m))[0]


@lru_cache(maxsize=32)
def _felt_m(signal, setup, at_m):
    """What is felt of the free plate, under any contact."""
    return felt_amplitude_m(*events(_free_m(signal, setup, at_m), signal.rate_hz))


@level_db.register
def _(model: FingersSensation, signal, contact):
    places_m = (model.places[name].on(model.setup) for name in model.fingers or model.places)
    alone = (TimeReversalSensation(model.setup, model.reference_m, finger_x_m=x, finger_y_m=y) for x, y in places_m)
    return max(level_db(finger, signal, contact) for finger in alone)


@level_db.register
def _(model: HybridSensation, signal, contact):
    foci, friction = _parts(signal)
    of_foci = level_db(TimeReversalSensation(model.setup, model.reference_m), foci, contact)
    return max(of_foci, level_db(model.friction, friction, contact) if friction.peak else -inf)


@lru_cache(maxsize=32)
def _parts(signal):
    """What the transducers play, until they are silent, and what the electrode does."""
    n_driven = int(np.flatnonzero(np.any(signal.samples[:-1], axis=0)).max(initial=0)) + 1
    foci, friction = signal.samples[:-1, :n_driven], signal.samples[-1:]
    return Signal(foci, signal.rate_hz, signal.unit), Signal(friction, signal.rate_hz, signal.unit)
