"""The level of a voltage by one formula, straight from the laws: what the scene of its model computes.

Nothing here knows a stage or an effect: the order of the laws is written out once more, and nothing is chosen.
"""

from functools import lru_cache
from math import inf, log10

import numpy as np

from tactometry.stimuli.electrovibration.attraction.force import electrostatic_force_n
from tactometry.stimuli.perception.channels import as_at_250_hz
from tactometry.stimuli.perception.detection import components

HIGH_SHARE = 1e-4
"""Share of the power below which aliases are 40 dB weaker than the rest."""


def level_db(model, signal, contact):
    """Sensation level (dB) by an `ElectrovibrationSensation`."""
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
    """Return the audible force components as their 250 Hz equivalents."""
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
