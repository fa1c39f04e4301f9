"""Compiled stick-slip motion: power series, with events at their roots."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tactometry.compiled import compiled, entry, uniform

from ...arrays import ComplexArray, FloatArray
from .compiled_loops import Bare, enter, response_at
from .phases import Heights, Phases

DEGREE = 20
REACH = 1.5
"""Longest step, times the fastest rate; the remainder of the series is 1.5^21/21! = 1e-16."""
N_LOOKS = 16
N_AT_ONCE = 100
Pair = tuple[int, int]
TOO_MANY, CHATTER, TOO_LONG = 1, 2, 3


class Layers(NamedTuple):
    """The circuit, its response to the sinusoids, and the force per square volt of its output."""

    gains: FloatArray
    dc_gain: float
    rates: FloatArray
    omegas: FloatArray
    responses: ComplexArray
    newton_per_v2: float


class Steps(NamedTuple):
    """Time from each node to the next, and the relaxations that still move there.

    `longest` (2, n_nodes) are the longest steps of a stuck finger, on which only the voltage acts, and of a slipping
    finger.
    """

    lengths: FloatArray
    moves: NDArray[np.bool_]
    longest: FloatArray


class ContactConstants(NamedTuple):
    """A finger, its friction, its normal force, and its motion ``speed + acceleration t`` over the screen."""

    mass_kg: float
    damping_n_s_per_m: float
    stiffness_n_per_m: float
    static: float
    kinetic: float
    gated: bool
    force_n: float
    speed_m_per_s: float
    acceleration_m_per_s2: float


class CircuitState(NamedTuple):
    """The circuit at one instant, changed in place: value and slope of the line, sinusoids, relaxations."""

    line: FloatArray
    turns: ComplexArray
    relaxed: FloatArray


class Series(NamedTuple):
    """Coefficients in powers of time over a step, changed in place."""

    relaxed: FloatArray
    force: FloatArray
    push: FloatArray
    stretch: FloatArray


class SkinState(NamedTuple):
    """Deflection of the skin and its rate, the direction of slip (0: stuck), and the time."""

    stretch_m: float
    rate_m_per_s: float
    direction: float
    time_s: float


@compiled
def _value(c: FloatArray, x: float) -> float:
    total = 0.0
    for n in range(len(c) - 1, -1, -1):
        total = total * x + c[n]
    return total


@compiled
def _slope(c: FloatArray, x: float) -> float:
    total = 0.0
    for n in range(len(c) - 1, 0, -1):
        total = total * x + n * c[n]
    return total


@compiled
def _falls(c: FloatArray) -> float:
    """Return where a polynomial first falls below 0 in (0, 1], or 2."""
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


@compiled
def _force_series(circuit: CircuitState, layers: Layers, moves: NDArray[np.bool_], h: float, series: Series) -> None:
    """Fill the power series of relaxations and force over `h`."""
    gains, dc_gain, rates, omegas, responses, _ = layers
    level, slope, states = circuit.line[0], circuit.line[1], series.relaxed
    n_relax, n_turns = len(gains), len(omegas)
    voltage, rise, turned = np.zeros(DEGREE + 1), np.zeros(DEGREE + 1), circuit.turns.copy()
    voltage[0], voltage[1], rise[0] = dc_gain * level, dc_gain * slope * h, slope * h
    for m in range(n_relax):
        # a decayed relaxation follows its input
        states[m, 0] = circuit.relaxed[m] if moves[m] else slope / rates[m]
        states[m, 1:].fill(0.0)
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
        for n in range(DEGREE + 1):
            voltage[n] += gains[m] * states[m, n]
    _square(voltage, layers.newton_per_v2, series.force)


@compiled
def _square(c: FloatArray, factor: float, out: FloatArray) -> None:
    for n in range(DEGREE + 1):
        total = 0.0
        for j in range(n + 1):
            total += c[j] * c[n - j]
        out[n] = factor * total


@compiled
def _push_series(skin: SkinState, contact: ContactConstants, series: Series) -> None:
    """Fill the series of friction and inertia on a slipping skin."""
    friction = skin.direction * contact.kinetic
    push, force = series.push, series.force
    for n in range(DEGREE + 1):
        push[n] = friction * force[n]
    push[0] += friction * contact.force_n + contact.mass_kg * contact.acceleration_m_per_s2


@compiled
def _slip_series(skin: SkinState, contact: ContactConstants, h: float, series: Series) -> None:
    """Fill the series of ``m s'' + c s' + k s = push`` in time over `h`."""
    m, c, k = contact.mass_kg, contact.damping_n_s_per_m, contact.stiffness_n_per_m
    push, out = series.push, series.stretch
    out[0], out[1] = skin.stretch_m, skin.rate_m_per_s * h
    for n in range(DEGREE - 1):
        pull = push[n] * h * h - c * h * (n + 1) * out[n + 1] - k * h * h * out[n]
        out[n + 2] = pull / (m * (n + 1) * (n + 2))


@compiled
def _stick_series(skin: SkinState, contact: ContactConstants, h: float, series: Series) -> None:
    out = series.stretch
    out.fill(0.0)
    out[0], out[1], out[2] = skin.stretch_m, skin.rate_m_per_s * h, contact.acceleration_m_per_s2 * h * h / 2


@compiled
def _breaks_loose(
    skin: SkinState, contact: ContactConstants, h: float, stretch: FloatArray, limit: FloatArray
) -> float:
    """Return when friction ``k s + c V`` passes its limit, in units of `h`."""
    holding = contact.stiffness_n_per_m * stretch
    holding[0] += contact.damping_n_s_per_m * skin.rate_m_per_s
    holding[1] += contact.damping_n_s_per_m * contact.acceleration_m_per_s2 * h
    return min(_falls(limit - holding), _falls(limit + holding))


@compiled
def _comes_to_rest(skin: SkinState, contact: ContactConstants, h: float, stretch: FloatArray) -> float:
    """Return when the skin reaches the finger's speed, in units of `h`."""
    ahead, direction = np.zeros(DEGREE + 1), skin.direction
    ahead[0], ahead[1] = direction * _speed(contact, skin.time_s), direction * contact.acceleration_m_per_s2 * h
    for n in range(DEGREE):
        ahead[n] -= direction * (n + 1) * stretch[n + 1] / h
    return _falls(ahead)


@compiled
def _strongest(contact: ContactConstants, force: FloatArray) -> FloatArray:
    """Return the friction limit of a stuck finger, without voltage if gated."""
    coefficient = contact.kinetic if contact.gated else contact.static
    loaded = coefficient * force
    loaded[0] += coefficient * contact.force_n
    bare_n = contact.static * contact.force_n
    if contact.gated and bare_n >= loaded[0]:
        loaded.fill(0.0)
        loaded[0] = bare_n
    return loaded


@compiled
def _speed(contact: ContactConstants, time: float) -> float:
    return contact.speed_m_per_s + contact.acceleration_m_per_s2 * time


@compiled
def _holding_friction(skin: SkinState, contact: ContactConstants) -> float:
    """Return the friction that holds the skin to the finger."""
    return contact.stiffness_n_per_m * skin.stretch_m + contact.damping_n_s_per_m * _speed(contact, skin.time_s)


@compiled
def _follow(skin: SkinState, contact: ContactConstants) -> SkinState:
    rate = skin.rate_m_per_s if skin.direction != 0 else _speed(contact, skin.time_s)
    return SkinState(skin.stretch_m, rate, skin.direction, skin.time_s)


@compiled
def _gives_way(skin: SkinState, contact: ContactConstants, limit_n: float) -> bool:
    """Return True if a stuck skin needs more than its static friction."""
    return skin.direction == 0 and abs(_holding_friction(skin, contact)) > limit_n * (1 + 1e-14)


@compiled
def _after(skin: SkinState, stretch: FloatArray, reached: float, unit_s: float, passed_s: float) -> SkinState:
    """Return the skin state after a part `reached` of a step, `passed_s` later."""
    rate_m_per_s = _slope(stretch, reached) / unit_s
    return SkinState(_value(stretch, reached), rate_m_per_s, skin.direction, skin.time_s + passed_s)


@compiled
def _change(skin: SkinState, contact: ContactConstants, events: FloatArray, n: int) -> SkinState:
    """Record event n; return the new skin state at the finger's speed."""
    direction = 0.0 if skin.direction != 0 else (1.0 if _holding_friction(skin, contact) > 0 else -1.0)
    events[n, 0], events[n, 1] = skin.time_s, direction
    return SkinState(skin.stretch_m, _speed(contact, skin.time_s), direction, skin.time_s)


@compiled
def _note(skin: SkinState, contact: ContactConstants, series: Series, row: FloatArray) -> bool:
    """Write the state at a node to the first result of `flow`."""
    s, rate, direction, force = skin.stretch_m, skin.rate_m_per_s, skin.direction, series.force[0]
    if direction == 0:
        second, lateral = contact.acceleration_m_per_s2, _holding_friction(skin, contact)
    else:
        pull = series.push[0] - contact.damping_n_s_per_m * rate - contact.stiffness_n_per_m * s
        second, lateral = pull / contact.mass_kg, direction * contact.kinetic * (contact.force_n + force)
    row[0], row[1], row[2], row[3], row[4], row[5] = s, rate, second, lateral, force, direction
    return True


@compiled
def _settle(i: int, free: FloatArray, heights: Heights, phases: Phases, circuit: CircuitState) -> None:
    """Set the circuit to node i, from the free decays of its piece."""
    piece = phases.piece[i]
    slope = heights.slopes[piece]
    circuit.line[0], circuit.line[1] = heights.offsets[piece] + slope * phases.since[i], slope
    for k in range(len(circuit.turns)):
        circuit.turns[k] = phases.turns[i, k] * heights.amplitudes[piece, k]
    for m in range(len(free)):
        circuit.relaxed[m] = free[m] * phases.decay[m, i] + slope * phases.line[m, i]
        circuit.relaxed[m] += response_at(m, i, piece, heights, phases)


@compiled
def _go_on(circuit: CircuitState, layers: Layers, series: Series, reached: float, passed: float) -> None:
    """Advance the circuit by a part `reached` of a step."""
    for m in range(len(layers.gains)):
        circuit.relaxed[m] = _value(series.relaxed[m], reached)
    for k in range(len(layers.omegas)):
        circuit.turns[k] *= np.exp(1j * layers.omegas[k] * passed)
    circuit.line[0] += circuit.line[1] * passed


@compiled
def _next_event(skin: SkinState, contact: ContactConstants, h: float, series: Series, limit: FloatArray) -> float:
    """Return the place of the next event in a step of length `h` (2: none)."""
    if skin.direction == 0:
        _stick_series(skin, contact, h, series)
        return _breaks_loose(skin, contact, h, series.stretch, limit)
    _slip_series(skin, contact, h, series)
    return _comes_to_rest(skin, contact, h, series.stretch)


@compiled
def _empty(layers: Layers) -> tuple[CircuitState, Series]:
    """Return empty arrays for the circuit and its series."""
    n, width = len(layers.gains), DEGREE + 1
    circuit = CircuitState(np.zeros(2), np.zeros(len(layers.omegas), np.complex128), np.zeros(n))
    return circuit, Series(np.zeros((n, width)), np.zeros(width), np.zeros(width), np.zeros(width))


def flow(
    heights: Heights, phases: Phases, layers: Layers, steps: Steps, contact: ContactConstants, start: float, most: Pair
) -> tuple[FloatArray, FloatArray, int, float]:
    """Return states at nodes, and events, of a finger that sticks at first.

    The rows of the first result are stretch, its first and second derivative, lateral force, electrostatic force and
    direction of slip (0: stuck). The rows of the second are the time of an event and the direction after it. The last
    two are a failure and its time: `TOO_MANY` events, `CHATTER` (too many at one instant), or `TOO_LONG`. `most` limits
    events and steps.
    """
    at = uniform(heights), tuple(phases), tuple(layers), tuple(steps)
    return _flow_entry(*at, uniform(contact), float(start), most)


@entry
def _flow_entry(
    heights: Bare, phases: Bare, layers: Bare, steps: Bare, contact: Bare, start: float, most: Pair
) -> tuple[FloatArray, FloatArray, int, float]:
    time = Heights(*heights), Phases(*phases), Layers(*layers), Steps(*steps)
    return _flow(*time, ContactConstants(*contact), start, most)


@compiled
def _flow(
    heights: Heights, phases: Phases, layers: Layers, steps: Steps, contact: ContactConstants, start: float, most: Pair
) -> tuple[FloatArray, FloatArray, int, float]:
    out, events = np.zeros((len(phases.piece), 6)), np.empty((most[0], 2))
    (circuit, series), free = _empty(layers), np.zeros(len(layers.gains))
    skin, held, n_events, n_here, n_steps = SkinState(start, contact.speed_m_per_s, 0.0, 0.0), -1, 0, 0, 0
    for i in range(len(phases.piece)):
        while held < phases.piece[i]:
            held += 1
            enter(held, i, heights, phases, free)
        _settle(i, free, heights, phases, circuit)
        rest, noted = steps.lengths[i] if i < len(steps.lengths) else 0.0, False
        while rest > 0 or not noted:
            h = min(rest, steps.longest[0 if skin.direction == 0 else 1, i])
            unit, n_steps = max(h, 1e-300), n_steps + 1
            _force_series(circuit, layers, steps.moves[i], unit, series)
            limit = _strongest(contact, series.force)
            skin = _follow(skin, contact)
            if _gives_way(skin, contact, limit[0]) and n_events < most[0]:
                skin = _change(skin, contact, events, n_events)
                n_events, n_here = n_events + 1, n_here + 1
                continue  # a slipping finger may need a shorter step
            _push_series(skin, contact, series)
            if not noted:
                noted = _note(skin, contact, series, out[i])
            if rest <= 0:
                break
            place = _next_event(skin, contact, unit, series, limit)
            reached, passed = min(place, 1.0), min(place, 1.0) * h
            _go_on(circuit, layers, series, reached, passed)
            rest = rest - passed if place <= 1 else (0.0 if h >= rest else rest - h)
            n_here = n_here if passed <= 1e-14 * skin.time_s else 0
            skin = _after(skin, series.stretch, reached, unit, passed)
            if place <= 1 and n_events < most[0]:
                skin = _change(skin, contact, events, n_events)
                n_events, n_here = n_events + 1, n_here + 1
            failure = _failure(n_events, n_here, n_steps, most)
            if failure:
                return out, events, failure, skin.time_s
    return out, events[:n_events], 0, skin.time_s


@compiled
def _failure(n_events: int, n_here: int, n_steps: int, most: Pair) -> int:
    if n_events == most[0]:
        return TOO_MANY
    if n_here > N_AT_ONCE:
        return CHATTER
    return TOO_LONG if n_steps > most[1] else 0
