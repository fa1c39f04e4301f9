"""The force of sampled voltages, straight between the samples, against that of the sine itself."""

from functools import partial

import numpy as np

from tactometry.stimuli.electrovibration import Sine, Skin, electrostatic_force_n, electrostatic_force_n_at
from tactometry.stimuli.electrovibration.attraction.force import force_per_square_volt_n
from tactometry.stimuli.electrovibration.skin.skin import sine_voltage_v

from ..cost.problem import Problem, Real, Reference, Rung, over_largest

FREQUENCY_HZ, DURATION_S, COARSEST_HZ = 240.0, 0.1, 5_000
FACTORS = (1, 4, 16, 64, 256)
AREA_M2 = 1e-4


def problem() -> Problem:
    """Force at 5 000 times a second, relative to its peak."""
    times_s = np.arange(round(DURATION_S * COARSEST_HZ)) / COARSEST_HZ
    return Problem(
        "largest error of the force of a 240 Hz sine over its peak, exact recurrence on samples",
        reference=Reference("the exact solution in pieces", lambda: _exact(times_s), 1e-12),
        independent=Reference("closed form of a sine", lambda: _closed_form(times_s), 1e-12),
        error=over_largest,
        rungs=tuple(Rung(f"{COARSEST_HZ * k / 1e3:g} kHz", partial(_sampled_force, k)) for k in FACTORS),
    )


def _sampled_force(factor: int) -> Real:
    rate_hz = COARSEST_HZ * factor
    times_s = np.arange(round(DURATION_S * rate_hz)) / rate_hz
    voltage_v = 100 * np.sin(2 * np.pi * FREQUENCY_HZ * times_s)
    force_n = electrostatic_force_n(voltage_v, rate_hz=rate_hz, skin=Skin(), area_m2=AREA_M2, law="sc_layer")
    return force_n[::factor]


def _exact(times_s: Real) -> Real:
    pieces = Sine(FREQUENCY_HZ, DURATION_S, ramp_s=0.0).pieces(40.0)
    return electrostatic_force_n_at(times_s, pieces, skin=Skin(), area_m2=AREA_M2, law="sc_layer")


def _closed_form(times_s: Real) -> Real:
    layer_v = sine_voltage_v(times_s, FREQUENCY_HZ, 100.0, Skin())
    return force_per_square_volt_n(Skin(), AREA_M2) * layer_v**2
