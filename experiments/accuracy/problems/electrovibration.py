"""Accuracy problems of electrovibration: force and break-away time."""

from functools import partial
from math import pi
from typing import Any

import numpy as np

from tactometry.stimuli.electrovibration import Finger, Sine, Skin, StickSlip, electrostatic_force_n, stick_slip
from tactometry.stimuli.electrovibration.attraction.force import force_form, force_per_square_volt_n
from tactometry.stimuli.electrovibration.motion.dry_friction import DryFriction
from tactometry.stimuli.electrovibration.motion.stick_slip import Travel
from tactometry.stimuli.electrovibration.skin.skin import sine_voltage_v

from ..measure import Problem, Real, Reference, Setting, over_largest

FREQUENCY_HZ, SINE_LASTS_S, COARSEST_HZ, AREA_M2 = 240.0, 0.1, 5_000, 1e-4
FACTORS = (1, 4, 16, 64, 256)
DURATION_S, FORCE_N, SPEED_M_PER_S = 0.2, 0.2, 0.05
DAMPING_N_S_PER_M = 4040 / (2 * pi * 13.8e3)
"""Low damping, so that the finger pad sticks for some milliseconds."""
N_SAMPLES = (20, 200, 2_000, 20_000)
SILENCE_DB_RE_1V = -120.0


def skin_propagator() -> Problem:
    """Compare the force of a sampled sine voltage with the closed form."""
    area: dict[str, Any] = {"skin": Skin(), "area_m2": AREA_M2, "law": "sc_layer"}

    def sampled(factor: int) -> Real:
        voltage_v = 100 * np.sin(2 * np.pi * FREQUENCY_HZ * sample_times_s(factor))
        return electrostatic_force_n(voltage_v, rate_hz=COARSEST_HZ * factor, **area)[::factor]

    def closed_form() -> Real:
        layer_v = sine_voltage_v(sample_times_s(1), FREQUENCY_HZ, 100.0, Skin())
        return force_per_square_volt_n(Skin(), AREA_M2) * layer_v**2

    return Problem(
        "largest error of the force of a 240 Hz sine over its peak, exact recurrence over samples",
        reference=Reference("closed form for a sine", closed_form, 1e-12),
        error=over_largest,
        settings=tuple(Setting(f"{COARSEST_HZ * k / 1e3:g} kHz", partial(sampled, k)) for k in FACTORS),
    )


def sample_times_s(factor: int) -> Real:
    """Return sample times at a multiple of the coarsest rate."""
    rate_hz = COARSEST_HZ * factor
    return np.arange(round(SINE_LASTS_S * rate_hz)) / rate_hz


def friction_events() -> Problem:
    """Compare the sampled time of the first break-away with the exact time."""
    finger, friction = pad(), DryFriction(gated=False)
    hold_n = friction.static * FORCE_N - finger.damping_n_s_per_m * SPEED_M_PER_S
    breakaway_s = hold_n / (finger.stiffness_n_per_m * SPEED_M_PER_S)
    return Problem(
        "error of the sampled time of the first break-away; the motion itself is exact",
        reference=Reference("closed form without voltage", lambda: breakaway_s, 1e-10),
        error=lambda ends_s, reference_s: max(abs(end_s / reference_s - 1) for end_s in ends_s),
        settings=(*(Setting(f"{n} samples", partial(_read_off, n)) for n in N_SAMPLES), Setting("event", _event)),
    )


def pad() -> Finger:
    """Return a finger pad with stick-slip friction."""
    return Finger.at_speed(SPEED_M_PER_S, DAMPING_N_S_PER_M)


def _motion(n_samples: int) -> StickSlip:
    pieces = Sine(60.0, DURATION_S, ramp_s=0.05).pieces(SILENCE_DB_RE_1V)
    form, times_s = force_form("sc_layer", Skin(), AREA_M2), np.linspace(0, DURATION_S, n_samples)
    contact: dict[str, Any] = {"finger": pad(), "friction": DryFriction(gated=False), "force_n": FORCE_N}
    return stick_slip(times_s, pieces, form, travel=Travel(SPEED_M_PER_S), **contact)


def _read_off(n_samples: int) -> tuple[float, float]:
    motion = _motion(n_samples)
    first = int(np.argmax(motion.direction != 0))
    return float(motion.t_s[first - 1]), float(motion.t_s[first])


def _event() -> tuple[float, float]:
    time_s = float(_motion(N_SAMPLES[0]).events_s[0])
    return time_s, time_s
