"""When a finger breaks away: read off samples of the motion, against the event itself."""

from functools import partial
from math import pi

import numpy as np

from tactometry.stimuli.electrovibration import DryFriction, Finger, Sine, Skin, StickSlip, Travel, stick_slip
from tactometry.stimuli.electrovibration.attraction.force import force_form

from ..cost.problem import Problem, Reference, Rung

DURATION_S, FORCE_N, SPEED_M_PER_S = 0.2, 0.2, 0.05
DAMPING_N_S_PER_M = 4040 / (2 * pi * 13.8e3)
"""Little, so that the pad sticks for some milliseconds."""
N_SAMPLES = (20, 200, 2_000, 20_000)
SILENCE_DB_RE_1V = -120.0


def problem() -> Problem:
    """The first break-away under next to no voltage, whose time is known in closed form."""
    finger, friction = pad(), DryFriction(gated=False)
    hold_n = friction.static * FORCE_N - finger.damping_n_s_per_m * SPEED_M_PER_S
    breakaway_s = hold_n / (finger.stiffness_n_per_m * SPEED_M_PER_S)
    return Problem(
        "time of the first break-away between two samples; the motion itself is exact",
        reference=Reference("the event, a root of the exact motion", _event, 1e-12),
        independent=Reference("closed form without voltage", lambda: (breakaway_s, breakaway_s), 1e-10),
        error=lambda ends_s, reference: max(abs(end_s / reference[0] - 1) for end_s in ends_s),
        rungs=(
            *(Rung(f"{n} samples", partial(_read_off, n)) for n in N_SAMPLES),
            Rung("event", _event),
        ),
    )


def pad() -> Finger:
    """What sticks and slips."""
    return Finger.at_speed(SPEED_M_PER_S, DAMPING_N_S_PER_M)


def _motion(n_samples: int) -> StickSlip:
    pieces = Sine(60.0, DURATION_S, ramp_s=0.05).pieces(SILENCE_DB_RE_1V)
    return stick_slip(
        np.linspace(0, DURATION_S, n_samples),
        pieces,
        force_form("sc_layer", Skin(), 1e-4),
        finger=pad(),
        friction=DryFriction(gated=False),
        force_n=FORCE_N,
        travel=Travel(SPEED_M_PER_S),
    )


def _read_off(n_samples: int) -> tuple[float, float]:
    """The last sample in stick and the first in slip."""
    motion = _motion(n_samples)
    first = int(np.argmax(motion.direction != 0))
    return float(motion.t_s[first - 1]), float(motion.t_s[first])


def _event() -> tuple[float, float]:
    """The event, twice."""
    time_s = float(_motion(N_SAMPLES[0]).events_s[0])
    return time_s, time_s
