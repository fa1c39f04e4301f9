"""The voltage across the corneum at the samples of a voltage."""

from tactometry.stimuli.arrays import FloatArray
from tactometry.stimuli.electrovibration.skin.skin import Skin


def corneum_voltage_v(v: FloatArray, rate_hz: float, skin: Skin, area_m2: float) -> FloatArray:
    """Voltage (..., n_samples) across the stratum corneum, from rest."""
    return skin.relaxations(area_m2).sampled(v, rate_hz)
