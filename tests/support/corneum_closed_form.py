"""Closed-form corneum voltage and force as references of the tests.

A skin with a body resistance or tissue has more relaxations than one, and is refused here: `Solution` solves it.
"""

from math import inf

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments import require
from tactometry.arguments.checked import checked
from tactometry.errors import InvalidParameter
from tactometry.stimuli.arrays import FloatArray
from tactometry.stimuli.electrovibration.attraction.force import force_per_square_volt_n
from tactometry.stimuli.electrovibration.skin.relaxation import phi1
from tactometry.stimuli.electrovibration.skin.skin import Skin, check_one_relaxation, in_taus, sine_voltage_v

__all__ = ["sine_voltage_v"]


@checked
def step_voltage_v(t_s: ArrayLike, voltage_v: float, skin: Skin) -> FloatArray:
    """Corneum voltage a time `t_s` (at least 0) after a step: ``k V0 exp(-t/tau)``."""
    return np.asarray(_peak_v(voltage_v, skin) * np.exp(-in_taus(t_s, skin)))


@checked
def step_impulse_n_s(voltage_v: float, skin: Skin, area_m2: float) -> float:
    """Integral (N s) of the force after a step: ``b k^2 V0^2 tau/2``."""
    return force_per_square_volt_n(skin, area_m2) * _peak_v(voltage_v, skin) ** 2 * skin.tau_s / 2


@checked
def rise_peak_v(rise_s: ArrayLike, voltage_v: float, skin: Skin) -> FloatArray:
    """Corneum voltage at the end of a linear rise: ``k V0 (tau/t_r)(1 - exp(-t_r/tau))``."""
    return _peak_v(voltage_v, skin) * phi1(in_taus(rise_s, skin))


@checked
def sine_mean_force_n(frequency_hz: ArrayLike, voltage_v: float, skin: Skin, area_m2: float) -> FloatArray:
    """Mean of the steady force of a sine, equal to the amplitude of its component at 2f: ``b V0^2 |H|^2/2``."""
    check_one_relaxation(skin)
    return force_per_square_volt_n(skin, area_m2) * (voltage_v * skin.gain(frequency_hz)) ** 2 / 2


@checked
def square_edge_v(frequency_hz: ArrayLike, voltage_v: float, skin: Skin) -> FloatArray:
    """Corneum voltage just after an edge of a steady square of +-V0: ``2 k V0/(1 + exp(-T/(2 tau)))``."""
    half_periods = in_taus(_period_s(frequency_hz) / 2, skin)
    return 2 * _peak_v(voltage_v, skin) / (1 + np.exp(-half_periods))


@checked
def square_mean_force_n(frequency_hz: ArrayLike, voltage_v: float, skin: Skin, area_m2: float) -> FloatArray:
    """Mean steady force of a square: ``b V+^2 (tau/T)(1 - exp(-T/tau))``, V+ from `square_edge_v`."""
    periods = in_taus(_period_s(frequency_hz), skin)
    return force_per_square_volt_n(skin, area_m2) * square_edge_v(frequency_hz, voltage_v, skin) ** 2 * phi1(periods)


@checked
def square_harmonic_force_n(
    n_harmonic: ArrayLike, frequency_hz: float, voltage_v: float, skin: Skin, area_m2: float
) -> FloatArray:
    """Amplitude of the steady force of a square at ``2 n f``, n from 1.

    ``4 b V+^2 (1 - exp(-T/tau))/(T |2/tau + 4 pi i n f|)``.
    """
    n = np.asarray(n_harmonic, dtype=np.float64)
    if ((n < 1) | (n != np.round(n))).any():
        raise InvalidParameter(
            f"square_harmonic_force_n.n_harmonic: found {n_harmonic!r}, expected whole numbers from 1 (the mean, at 0, "
            "is square_mean_force_n)"
        )
    edge_force_n = force_per_square_volt_n(skin, area_m2) * square_edge_v(frequency_hz, voltage_v, skin) ** 2
    require.positive("square_harmonic_force_n", frequency_hz=frequency_hz)
    decay_per_s = 1 / skin.tau_s if skin.tau_s > 0 else inf
    rate_per_s: FloatArray = np.abs(2 * decay_per_s + 4j * np.pi * n * frequency_hz)
    charged = -np.expm1(-decay_per_s / frequency_hz)
    return np.asarray(4 * edge_force_n * charged * frequency_hz / rate_per_s)


def _period_s(frequency_hz: ArrayLike) -> FloatArray:
    return 1 / require.positive_array("frequency_hz", frequency_hz)


def _peak_v(voltage_v: float, skin: Skin) -> float:
    check_one_relaxation(skin)
    return skin.k * voltage_v


def corneum_voltage_v(v: FloatArray, rate_hz: float, skin: Skin, area_m2: float) -> FloatArray:
    """Voltage (..., n_samples) across the stratum corneum, from rest."""
    return skin.relaxations(area_m2).sampled(v, rate_hz)
