"""Charge and current that a finger draws from the electrode, for the limits of the output."""

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments import require
from tactometry.arguments.annotations import Positive
from tactometry.arguments.checked import checked

from ...arrays import FloatArray
from ..skin.relaxation import Solution
from ..skin.skin import INSULATOR, Skin
from ..waveforms.pieces import Pieces


@checked
def charge_c(voltage_v: ArrayLike, *, rate_hz: Positive, skin: Skin, area_m2: float) -> FloatArray:
    """Charge (C) on the electrode under the finger at the samples (..., n_samples) of a voltage, from rest.

    ``C_i V_i``: the insulator does not leak, so its charge is all that has flowed.

    >>> round(float(charge_c([100.0], rate_hz=1e4, skin=Skin(), area_m2=1e-4)[0]) * 1e9, 3)
    193.996
    """
    v = require.samples("charge_c.voltage_v", voltage_v)
    insulator_v = skin.stack.relaxations(INSULATOR, area_m2).sampled(v, rate_hz)
    return _insulator_capacitance_f(skin, area_m2) * insulator_v


@checked
def current_a(voltage_v: ArrayLike, *, rate_hz: float, skin: Skin, area_m2: float) -> FloatArray:
    """Mean current (A) over the sample before each sample: exact, and finite where the voltage jumps."""
    charge = charge_c(voltage_v, rate_hz=rate_hz, skin=skin, area_m2=area_m2)
    return np.diff(charge, prepend=0.0, axis=-1) * rate_hz


@checked
def charge_c_at(t_s: ArrayLike, pieces: Pieces, skin: Skin, area_m2: float) -> FloatArray:
    """Charge (C) at any time, exactly, for a voltage in pieces."""
    return _insulator_capacitance_f(skin, area_m2) * _insulator(pieces, skin, area_m2).at(t_s)


@checked
def current_a_at(t_s: ArrayLike, pieces: Pieces, skin: Skin, area_m2: float) -> FloatArray:
    """Current (A) at any time inside of the pieces, exactly; a jump without body resistance is an
    impulse beside."""
    return _insulator_capacitance_f(skin, area_m2) * _insulator(pieces, skin, area_m2).slope_at(t_s)


def _insulator(pieces: Pieces, skin: Skin, area_m2: float) -> Solution:
    return Solution(pieces, skin.stack.relaxations(INSULATOR, area_m2))


def _insulator_capacitance_f(skin: Skin, area_m2: float) -> float:
    """Of the insulator alone, without the gap."""
    return area_m2 / skin.stack.layers[INSULATOR].elastance_m2_per_f
