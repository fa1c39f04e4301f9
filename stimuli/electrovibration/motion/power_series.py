"""Stick and slip between events as power series, compiled: exact flow, events at the roots of polynomials."""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .compiled_loops import answered, enter

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
compiled: Any = njit(cache=True)

DEGREE = 20
REACH = 1.5
"""Longest step in units of the fastest rate: 1.5^21/21! = 1e-16 is left out."""
N_LOOKS = 16
N_AT_ONCE = 100
TOO_MANY, CHATTER, TOO_LONG = 1, 2, 3


@compiled  # type: ignore[untyped-decorator]  # pragma: no cover
def _value(c: Real, x: float) -> float:
    total = 0.0
    for n in range(len(c) - 1, -1, -1):
        total = total * x + c[n]
    return total


@compiled  # type: ignore[untyped-decorator]  # pragma: no cover
def _slope(c: Real, x: float) -> float:
    total = 0.0
    for n in range(len(c) - 1, 0, -1):
        total = total * x + n * c[n]
    return total


@compiled  # type: ignore[untyped-decorator]  # pragma: no cover
def _falls(c: Real) -> float:
    """The first place in (0, 1] where the polynomial falls below 0, seen from `N_LOOKS` places; 2 if nowhere."""
    low = 0.0
    for look in range(1, N_LOOKS + 1):
        high = look / N_LOOKS
        if _value(c, high) < 0:
            for _ in range(60):
                middle = 0.5 * (low + high)
                if _value(c, middle) < 0:
                    high = middle
                else:
                    low = middle
            return high
        low = high
    return 2.0


@compiled  # type: ignore[untyped-decorator]  # pragma: no cover
def _force_series(
    y: Real, turns: Complex, level: float, slope: float, rates: Real, gains: Real, moves: NDArray[np.bool_],
    dc_gain: float, omegas: Real, responses: Complex, h: float, newton: float, states: Real, force: Real,
) -> None:  # fmt: skip
    """Coefficients of the relaxations (`states`, in place) and of the force in powers of time over `h`."""
    n_relax, n_turns = len(gains), len(omegas)
    voltage, rise, turned = np.zeros(DEGREE + 1), np.zeros(DEGREE + 1), turns.copy()
    voltage[0], voltage[1], rise[0] = dc_gain * level, dc_gain * slope * h, slope * h
    for m in range(n_relax):
        states[m, 0] = y[m] if moves[m] else slope / rates[m]
        states[m, 1:] = 0.0
    for n in range(DEGREE + 1):
        for k in range(n_turns):
            voltage[n] += dc_gain * turned[k].real
            rise[n] += (1j * omegas[k] * h * turned[k]).real
            for m in range(n_relax):
                if not moves[m]:
                    states[m, n] += (responses[m, k] * turned[k]).real
        for k in range(n_turns):
            turned[k] *= 1j * omegas[k] * h / (n + 1)
        if n < DEGREE:
            for m in range(n_relax):
                if moves[m]:
                    states[m, n + 1] = (rise[n] - h * rates[m] * states[m, n]) / (n + 1)
    for m in range(n_relax):
        voltage += gains[m] * states[m]
    for n in range(DEGREE + 1):
        total = 0.0
        for j in range(n + 1):
            total += voltage[j] * voltage[n - j]
        force[n] = newton * total


@compiled  # type: ignore[untyped-decorator]  # pragma: no cover
def _slip_series(s: float, rate: float, push: Real, h: float, m: float, c: float, k: float, out: Real) -> None:
    """``m s'' + c s' + k s = push`` from ``s, s' = rate`` in powers of time over `h`."""
    out[0], out[1] = s, rate * h
    for n in range(DEGREE - 1):
        pull = push[n] * h * h - c * h * (n + 1) * out[n + 1] - k * h * h * out[n]
        out[n + 2] = pull / (m * (n + 1) * (n + 2))


@compiled  # type: ignore[untyped-decorator]  # pragma: no cover
def _stick_series(s: float, speed: float, acceleration: float, h: float, out: Real) -> None:
    out[:] = 0.0
    out[0], out[1], out[2] = s, speed * h, acceleration * h * h / 2


@compiled  # type: ignore[untyped-decorator]  # pragma: no cover
def _breaks_loose(stretch: Real, speed: float, acceleration: float, h: float, c: float, k: float, limit: Real) -> float:
    """Where the friction that a stuck finger asks for, ``k s + c V``, passes the limit, in units of `h`."""
    asked = k * stretch
    asked[0] += c * speed
    asked[1] += c * acceleration * h
    place: float = min(_falls(limit - asked), _falls(limit + asked))
    return place


@compiled  # type: ignore[untyped-decorator]  # pragma: no cover
def _comes_to_rest(stretch: Real, speed: float, acceleration: float, h: float, direction: float) -> float:
    """Where the skin is as fast as the finger that slips over it, in units of `h`."""
    ahead = np.zeros(DEGREE + 1)
    ahead[0], ahead[1] = direction * speed, direction * acceleration * h
    for n in range(DEGREE):
        ahead[n] -= direction * (n + 1) * stretch[n + 1] / h
    place: float = _falls(ahead)
    return place


@compiled  # type: ignore[untyped-decorator]  # pragma: no cover
def _strongest(force: Real, force_n: float, static: float, kinetic: float, gated: bool) -> Real:
    """The friction that a stuck finger can bear. Gated, the voltage does not help it to stick, only to slip."""
    loaded, bare = static * force, np.zeros(DEGREE + 1)
    loaded[0] += static * force_n
    if not gated:
        return loaded
    slipping = kinetic * force
    slipping[0] += kinetic * force_n
    bare[0] = static * force_n
    return bare if bare[0] >= slipping[0] else slipping


@compiled  # type: ignore[untyped-decorator]  # pragma: no cover
def flow(  # noqa: PLR0912, PLR0915
    offsets: Real, slopes: Real, amplitudes: Complex, newton: float,
    piece: NDArray[np.intp], since: Real, decay: Real, line: Real, spans: Real, end_decay: Real, end_line: Real,
    turns: Complex, responses: Complex, gains: Real, dc_gain: float,
    rates: Real, omegas: Real, lengths: Real, moves: NDArray[np.bool_], longest: Real,
    finger: Real, friction: Real, travel: Real, gated: bool, n_events_max: int, n_steps_max: int,
) -> tuple[Real, Real, int, float]:  # fmt: skip
    """States at the nodes and the events.

    `finger` is (mass, damping, stiffness), `friction` (static, kinetic, normal force), `travel` (speed,
    acceleration, stretch at time 0), `longest` (2, n_nodes) the longest steps of a stuck finger, which only the voltage
    moves, and of one that slips. Rows of the first result: stretch, its rate, its second derivative, lateral
    force, electrostatic force, direction of slip (0: stuck); rows of the second: time of an event, direction after.
    The last two are a failure (`TOO_MANY` events, `CHATTER`: that many at one instant, or `TOO_LONG`: more than
    `n_steps_max` steps) and its time.
    """
    m, c, k = finger
    static, kinetic, force_n = friction
    n_nodes, n_relax, n_turns = len(piece), len(gains), len(omegas)
    out, events = np.zeros((n_nodes, 6)), np.empty((n_events_max, 2))
    free, y, states = np.zeros(n_relax), np.zeros(n_relax), np.zeros((n_relax, DEGREE + 1))
    force, stretch, push = np.zeros(DEGREE + 1), np.zeros(DEGREE + 1), np.zeros(DEGREE + 1)
    s, rate, direction = travel[2], travel[0], 0.0
    held, n_events, n_here, n_steps, time = -1, 0, 0, 0, 0.0
    for i in range(n_nodes):
        now = piece[i]
        while held < now:
            held += 1
            enter(held, i, offsets, slopes, amplitudes, turns, spans, end_decay, end_line, responses, free)
        turn = turns[i] * amplitudes[now]
        for r in range(n_relax):
            y[r] = free[r] * decay[r, i] + slopes[now] * line[r, i]
            y[r] += answered(turns, i, responses, r, amplitudes, now)
        level = offsets[now] + slopes[now] * since[i]
        rest, first = lengths[i] if i < len(lengths) else 0.0, True
        while first or rest > 0:
            h = min(rest, longest[0 if direction == 0 else 1, i])
            n_steps += 1
            unit = max(h, 1e-300)
            here = travel[0] + travel[1] * time
            _force_series(
                y, turn, level, slopes[now], rates, gains, moves[i], dc_gain, omegas, responses, unit, newton,
                states, force,
            )  # fmt: skip
            limit = _strongest(force, force_n, static, kinetic, gated)
            if direction == 0:
                asked = k * s + c * here
                rate = here
                if abs(asked) > limit[0] * (1 + 1e-14) and n_events < n_events_max:
                    direction = np.sign(asked)
                    events[n_events] = time, direction
                    n_events, n_here = n_events + 1, n_here + 1
                    continue  # a step of one that slips may be shorter
            push[:] = direction * kinetic * force
            push[0] += direction * kinetic * force_n + m * travel[1]
            if first:
                slipping = (push[0] - c * rate - k * s) / m
                lateral = direction * kinetic * (force_n + force[0]) if direction != 0 else k * s + c * here
                out[i] = s, rate, travel[1] if direction == 0 else slipping, lateral, force[0], direction
                first = False
            if rest <= 0:
                break
            if direction == 0:
                _stick_series(s, here, travel[1], unit, stretch)
                place = _breaks_loose(stretch, here, travel[1], unit, c, k, limit)
            else:
                _slip_series(s, rate, push, unit, m, c, k, stretch)
                place = _comes_to_rest(stretch, here, travel[1], unit, direction)
            reached = min(place, 1.0)
            passed = reached * h
            s, rate = _value(stretch, reached), _slope(stretch, reached) / unit
            for r in range(n_relax):
                y[r] = _value(states[r], reached)
            for q in range(n_turns):
                turn[q] *= np.exp(1j * omegas[q] * passed)
            level += slopes[now] * passed
            rest = rest - passed if place <= 1 else (0.0 if h >= rest else rest - h)
            n_here = n_here if passed <= 1e-14 * time else 0
            time += passed
            if place <= 1 and n_events < n_events_max:
                here = travel[0] + travel[1] * time
                rate = here
                direction = 0.0 if direction != 0 else (1.0 if k * s + c * here > 0 else -1.0)
                events[n_events] = time, direction
                n_events, n_here = n_events + 1, n_here + 1
            if n_events == n_events_max or n_here > N_AT_ONCE:
                return out, events, TOO_MANY if n_events == n_events_max else CHATTER, time
            if n_steps > n_steps_max:
                return out, events, TOO_LONG, time
    return out, events[:n_events], 0, time
