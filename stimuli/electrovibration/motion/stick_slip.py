"""Stick-slip motion with exact events and unsmoothed Coulomb friction."""

from dataclasses import dataclass
from functools import lru_cache
from math import inf, pi, sqrt
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments import require
from tactometry.arguments.checked import NotNegative, checked
from tactometry.errors import InvalidParameter

from ...arrays import FloatArray, IndexArray
from ..attraction.force import ForceForm
from ..waveforms.pieces import Pieces
from .driven_motion import Timing, check_times
from .dry_friction import DryFriction
from .pad import Finger
from .phases import Phases, heights, moving, nodes_of, phases

if TYPE_CHECKING:
    from . import power_series


N_STEPS_MAX = 2_000_000
"""Largest number of series steps in one call, which take about two seconds."""


@checked
@dataclass(frozen=True)
class Travel:
    """Velocity of the finger over the screen: ``V = speed + acceleration t``, of either sign; 0 is a finger at rest.

    `stretch_m` is the deflection of the skin at time 0, at which the finger sticks.
    """

    speed_m_per_s: float = 0.05
    acceleration_m_per_s2: float = 0.0
    stretch_m: float = 0.0


@dataclass(frozen=True, eq=False)
class StickSlip:
    """Motion of a finger (n_times,) and its stick-slip events (n_events,).

    `stretch_m` is the deflection of the skin against the finger with its derivatives, `lateral_n` the friction,
    `direction` 1 or -1 in slip and 0 in stick; `events_s` are the times at which it changes to `event_directions`.
    """

    t_s: FloatArray
    stretch_m: FloatArray
    stretch_m_per_s: FloatArray
    stretch_m_per_s2: FloatArray
    lateral_n: FloatArray
    electrostatic_n: FloatArray
    direction: FloatArray
    events_s: FloatArray
    event_directions: FloatArray


@checked
def stick_slip(
    t_s: ArrayLike,
    pieces: Pieces,
    form: ForceForm,
    *,
    finger: Finger,
    friction: DryFriction,
    force_n: NotNegative,
    travel: Travel,
    n_events_max: int = 100_000,
) -> StickSlip:
    """Return the motion of a finger that sticks and slips.

    It sticks while friction can hold it, and slips until the skin is at rest on the screen.

    In stick the skin follows the screen, ``s' = V``, and needs a friction of ``k s + c V``. It breaks away above ``mu_s
    (F_n + F_e)``. In slip ``m s'' + c s' + k s = m V' + sign mu_k (F_n + F_e)``. Between events the motion is a power
    series of 20 terms over at most 1.5 times the fastest time constant. An event is the root of a polynomial.

    Raises `InvalidParameter` if a value is outside of its domain, or there are `n_events_max` events or more.

    Parameters
    ----------
    t_s : (n_times,) array
        Ascending from at least 0 to at most the end of the voltage.
    force_n : float
        Normal force, at least 0.
    """
    from . import power_series

    t = np.asarray(t_s, dtype=np.float64)
    require.whole("stick_slip", lowest=1, n_events_max=n_events_max)
    places, shared, layers, steps = _plan(Timing(pieces, t), form, finger)
    pad = finger.mass_kg, finger.damping_n_s_per_m, finger.stiffness_n_per_m
    moved = travel.speed_m_per_s, travel.acceleration_m_per_s2
    contact = power_series.ContactConstants(*pad, friction.static, friction.kinetic, friction.gated, force_n, *moved)
    states, events, failure, time_s = power_series.flow(
        heights(pieces), shared, layers, steps, contact, travel.stretch_m, (n_events_max, N_STEPS_MAX)
    )
    if failure == power_series.TOO_LONG:
        raise InvalidParameter(
            f"stick_slip: found more than {N_STEPS_MAX:.3g} steps of the series at {time_s:.6g} s of this signal (the "
            f"finger moves at up to {_fastest_rad_per_s(finger):.3g} rad/s), expected fewer; use a heavier "
            "or softer finger, or shorten the signal"
        )
    if failure:
        at_once = "at one instant" if failure == power_series.CHATTER else f"(n_events_max, {n_events_max}, is reached)"
        raise InvalidParameter(
            f"stick_slip: found too many changes between stick and slip {at_once}, at {time_s:.6g} s; "
            "expected fewer: raise the damping or the static friction, or shorten the signal"
        )
    stretch, rate, second, lateral, electrostatic, direction = states[places].T
    return StickSlip(t, stretch, rate, second, lateral, electrostatic, direction, events[:, 0], events[:, 1])


@lru_cache(maxsize=64)
def _plan(
    timing: Timing, form: ForceForm, finger: Finger
) -> "tuple[IndexArray, Phases, power_series.Layers, power_series.Steps]":
    """Prepare nodes, phases, circuit and steps, the same at all levels."""
    from . import power_series

    check_times(timing.t_s, timing.pieces)
    relaxations = form.relaxations
    nodes = nodes_of(timing.pieces, relaxations, timing.t_s)
    shared = phases(timing.pieces, relaxations, nodes)
    rates, omegas = np.array(relaxations.rates_per_s), 2 * pi * timing.pieces.frequencies_hz
    gains, moves = np.array(relaxations.gains), moving(shared.since, relaxations)
    # the force is quadratic in the voltage, which doubles its rates
    electric = np.max(2 * rates[None, :] * moves, axis=1, initial=2 * omegas.max(initial=0.0))
    # (2, n_nodes), stick and slip; in stick the pad follows the screen and does not swing
    fastest = np.stack([electric, np.maximum(electric, _fastest_rad_per_s(finger))])
    longest = np.divide(power_series.REACH, fastest, out=np.full(fastest.shape, inf), where=fastest > 0)
    layers = power_series.Layers(gains, relaxations.dc_gain, rates, omegas, shared.responses, form.newton_per_v2)
    return np.searchsorted(nodes, timing.t_s), shared, layers, power_series.Steps(np.diff(nodes), moves, longest)


def _fastest_rad_per_s(finger: Finger) -> float:
    """Return the fastest rate in slip: pad resonance or decay of its speed."""
    return max(sqrt(finger.stiffness_n_per_m / finger.mass_kg), finger.damping_n_s_per_m / finger.mass_kg)
