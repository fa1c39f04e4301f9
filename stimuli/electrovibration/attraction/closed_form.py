"""Voltage across the corneum in closed form, of an insulator and a leaky corneum.

A skin with a body resistance or tissue has more relaxations than one, and is refused here: `Solution` solves it.
"""

from math import inf

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments.checked import checked
from tactometry.errors import InvalidParameter

from ...arrays import FloatArray
from ..skin.skin import Skin


@checked
def sine_voltage_v(t_s: ArrayLike, frequency_hz: float, voltage_v: float, skin: Skin) -> FloatArray:
    """Corneum voltage of ``V0 sin(w t)`` from rest: ``V0 |H| (sin(wt + phi) - sin(phi) exp(-t/tau))``."""
    check_one_relaxation(skin)
    # the free decay starts at minus the steady voltage at time 0, so that the sum begins at rest
    response = complex(skin.response(frequency_hz))
    steady = response * np.exp(2j * np.pi * frequency_hz * np.asarray(t_s, dtype=np.float64))
    return np.asarray(voltage_v * (steady.imag - response.imag * np.exp(-in_taus(t_s, skin))))


def check_one_relaxation(skin: Skin) -> None:
    for name, neutral in (("body_resistance_ohm", 0.0), ("tissue", None)):
        if getattr(skin, name) != neutral:
            raise InvalidParameter(
                f"closed_form: found a skin with Skin.{name} other than {neutral}, which these formulas have no term "
                f"for; expected {neutral}, or take Solution or electrostatic_force_n_at"
            )


def in_taus(t_s: ArrayLike, skin: Skin) -> FloatArray:
    """Time in units of tau."""
    t = np.asarray(t_s, dtype=np.float64)
    if (t < 0).any():
        raise InvalidParameter(f"closed_form.t_s: found {t.min()} s, expected at least 0")
    return t / skin.tau_s if skin.tau_s > 0 else np.where(t == 0, 0.0, inf)
