"""Motion of a linear system driven by the force of a piecewise voltage.

A relaxation follows its input once it has decayed (`phases.DECAYED` time constants after the start of a piece). It is
then left out of the flow, which bounds every exponent.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tactometry.arguments import require

from ...arrays import FloatArray, IndexArray
from ..attraction.force import ForceForm
from ..skin.relaxation import Relaxations, Solution, scan
from ..waveforms.pieces import Pieces
from .phases import Phases, moving, nodes_of, phases

REACH: Final = 0.5
"""Longest step of the series, times the fastest rate."""
TERMS: Final = 20
"""Terms of the series; the remainder is 0.5^21/21! = 1e-26."""


@dataclass(frozen=True)
class Circuit:
    """States of the circuit: relaxations, line and sinusoids.

    `active` marks the relaxations that have not decayed.

    Order of the states: active relaxations, value of the line (if used), slope of the line (if any), then the real and
    imaginary part of ``c exp(2 pi i f t)`` for each frequency.
    """

    relaxations: Relaxations
    frequencies_hz: tuple[float, ...]
    has_slope: bool
    active: tuple[bool, ...]

    @property
    def has_line(self) -> bool:
        return self.relaxations.dc_gain != 0

    def matrix(self) -> FloatArray:
        """Matrix (n_states, n_states) of the states' linear equation."""
        n_active, n = sum(self.active), self.n_states
        z = np.zeros((n, n))
        first = n - 2 * len(self.frequencies_hz)
        rates = [r for r, moves in zip(self.relaxations.rates_per_s, self.active, strict=True) if moves]
        z[range(n_active), range(n_active)] = np.negative(rates)
        if self.has_slope:
            z[: first - 1, first - 1] = 1.0  # the slope of the line drives the line and every relaxation
        for k, f_hz in enumerate(self.frequencies_hz):
            real, imag = first + 2 * k, first + 2 * k + 1
            omega = 2 * np.pi * f_hz
            z[real, imag], z[imag, real] = -omega, omega
            z[:n_active, imag] = -omega  # v' of the real part of a phasor is -omega times its imaginary part
        return z

    def output(self) -> FloatArray:
        """Return the voltage as a linear form (n_states,) of the states."""
        r = self.relaxations
        moving = [gain for gain, moves in zip(r.gains, self.active, strict=True) if moves]
        still = [(gain, rate) for gain, rate, m in zip(r.gains, r.rates_per_s, self.active, strict=True) if not m]
        # a decayed relaxation follows its input: slope/rate, or the response to a sinusoid
        line = [r.dc_gain] if self.has_line else []
        slope = [sum(gain / rate for gain, rate in still)] if self.has_slope else []
        turns = Relaxations(tuple(g for g, _ in still), tuple(s for _, s in still), r.dc_gain)
        responses = [(h.real, -h.imag) for h in turns.response(self.frequencies_hz)]
        return np.array([*moving, *line, *slope, *(x for pair in responses for x in pair)])

    @property
    def n_states(self) -> int:
        return sum(self.active) + self.has_line + self.has_slope + 2 * len(self.frequencies_hz)

    def active_places(self) -> IndexArray:
        """Return indices (n_states,) among the states of an all-active circuit."""
        n_all = len(self.active) + self.n_states - sum(self.active)
        return np.flatnonzero([*self.active, *([True] * (n_all - len(self.active)))])


@dataclass(frozen=True)
class LinearSystem:
    """Linear system ``x' = M x + b F``, with M (n, n) and b (n,) as tuples."""

    matrix: tuple[tuple[float, ...], ...]
    input: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class Flows:
    """``x_a(t + h) = sum_b states_ab x_b(t) + sum_ij forms_aij z_i(t) z_j(t)`` for lengths h, for 1 N/V^2.

    `states` (n_lengths, n, n) and `forms` (n_lengths, n, n_states, n_states) of a circuit with n_states; `change`
    (n_lengths, n_states, n_states) are the maps of the circuit's states minus the identity, which keeps the digits of a
    small phase.
    """

    states: FloatArray
    forms: FloatArray
    change: FloatArray

    def twice(self) -> "Flows":
        """Return the flows over doubled lengths."""
        over = (np.eye(self.change.shape[-1]) + self.change)[:, None]
        forms = np.einsum("lab,lbij->laij", self.states, self.forms) + over.swapaxes(-1, -2) @ self.forms @ over
        return Flows(self.states @ self.states, forms, 2 * self.change + self.change @ self.change)


def flows(circuit: Circuit, system: LinearSystem, lengths_s: FloatArray) -> Flows:
    """Return the exact flows over lengths of time (n_lengths,) above 0."""
    # an upper bound of the rates of the driven states and of products of circuit states, above 0
    electric, driven = (np.abs(np.linalg.eigvals(m)).max(initial=0.0) for m in (circuit.matrix(), system.matrix))
    fastest_per_s = float(2 * electric + driven) or 1.0

    doublings = np.maximum(0, np.ceil(np.log2(fastest_per_s * lengths_s / REACH))).astype(np.intp)
    flow = _short_flows(circuit, system, fastest_per_s, np.ldexp(fastest_per_s * lengths_s, -doublings))
    for done in range(doublings.max(initial=0)):
        on = doublings > done
        longer = Flows(flow.states[on], flow.forms[on], flow.change[on]).twice()
        flow.states[on], flow.forms[on], flow.change[on] = longer.states, longer.forms, longer.change
    return flow


def _short_flows(circuit: Circuit, system: LinearSystem, unit_per_s: float, lengths: FloatArray) -> Flows:
    """Return flows over lengths (n_lengths,) up to `REACH` by power series."""
    z, m = circuit.matrix() / unit_per_s, np.array(system.matrix) / unit_per_s
    factors = np.cumprod(lengths[:, None] / np.arange(1, TERMS + 1), axis=1)  # h^k/k! for k from 1

    def total(terms: list[FloatArray]) -> FloatArray:
        return np.asarray(np.einsum("lk,k...->l...", factors, np.array(terms)))

    g = circuit.output()
    square = np.multiply.outer(np.array(system.input) / unit_per_s, np.outer(g, g))
    pulls = _derivatives(square, lambda form: z.T @ form + form @ z)
    forms = [pulls[0]]
    for pull in pulls[1:]:
        forms.append(np.einsum("ab,bij->aij", m, forms[-1]) + pull)
    return Flows(
        np.eye(len(m)) + total(_derivatives(m, lambda power: m @ power)),
        total(forms),
        total(_derivatives(z, lambda power: z @ power)),
    )


def _derivatives(first: FloatArray, derive: Callable[[FloatArray], FloatArray]) -> list[FloatArray]:
    """Return `TERMS` derivatives, each computed from the previous one."""
    result = [first]
    while len(result) < TERMS:
        result.append(derive(result[-1]))
    return result


Kind = tuple[float, tuple[bool, ...]]
"""Length of an interval and the relaxations that move in it."""
CYCLES_MAX = 1e7
"""Largest number of periods of a lag or finger between two times; the rounding error is then 1e-9 of the largest
force."""


AT_ONCE = 1024
"""Nodes per matrix product: few enough that the states stay in cache and BLAS starts no threads."""


class DrivenPlan(NamedTuple):
    """Level-independent plan of a driven linear system over time.

    It contains the requested nodes, the first node of each piece, and whether the circuit's states include a line and a
    slope. The linear `form` of the states is the voltage across the layer. Over interval i the states advance by
    ``maps[kinds[i]]`` and add the quadratic forms ``drives[kinds[i]]`` of the circuit's states.
    """

    phases: Phases
    wanted: IndexArray
    first: IndexArray
    has_line: bool
    has_slope: bool
    form: FloatArray
    kinds: IndexArray
    maps: FloatArray
    drives: FloatArray


def first_order_response(pieces: Pieces, force: ForceForm, system: LinearSystem, t_s: ArrayLike) -> FloatArray:
    """Return the exact state (n_times,) of a first-order system from 0.

    `compiled_loops` handles several states. A single state needs no loop, and importing numba takes half a second.
    """
    plan = plan_of(Timing(pieces, t_s), force.relaxations, system)
    taken_up = force.newton_per_v2 * _products(circuit_states(pieces, force.relaxations, plan), plan)
    return np.asarray(scan(plan.maps[plan.kinds, 0, 0], np.r_[0.0, taken_up])[plan.wanted])


def circuit_states(pieces: Pieces, relaxations: Relaxations, plan: DrivenPlan) -> FloatArray:
    """Return the states (n_states, n_nodes) in the order of `Circuit`."""
    phases, piece, n_relax = plan.phases, plan.phases.piece, len(plan.phases.decay)
    at, slopes = n_relax + plan.has_line + plan.has_slope, pieces.slopes_v_per_s[piece]
    z, turned = np.empty((len(plan.form), len(piece))), phases.turns * pieces.harmonics_v[piece]
    z[at::2], z[at + 1 :: 2] = turned.real.T, turned.imag.T
    responses = np.stack([phases.responses.real, -phases.responses.imag], axis=-1).reshape(n_relax, len(z) - at)
    free = Solution(pieces, relaxations).free_decays
    z[:n_relax] = free[:, piece] * phases.decay + slopes * phases.line + np.einsum("mk,kn->mn", responses, z[at:])
    if plan.has_line:
        z[n_relax] = pieces.offsets_v[piece] + slopes * phases.since
    if plan.has_slope:
        z[at - 1] = slopes
    return z


def _products(z: FloatArray, plan: DrivenPlan) -> FloatArray:
    """Return the driven state's increment per interval, for 1 N/V^2."""
    order = np.argsort(plan.kinds, kind="stable")
    starts = np.flatnonzero(np.diff(plan.kinds[order])) + 1
    taken_up = np.empty(len(order))
    for alike in np.split(order, np.union1d(starts, np.arange(AT_ONCE, len(order), AT_ONCE))):
        here = z[:, alike]
        taken_up[alike] = np.einsum("in,in->n", plan.drives[plan.kinds[alike[0]], 0] @ here, here)
    return taken_up


def check_times(t: FloatArray, pieces: Pieces) -> None:
    """Raise an error unless the times ascend within the pieces."""
    require.finite_array("t_s", t)
    inside = t.ndim == 1 and t.size > 0 and t[0] >= 0 and t[-1] <= pieces.end_s and (np.diff(t) > 0).all()
    found = f"{t.size} times in shape {t.shape}"
    require.expect(inside, "t_s", found, f"ascending times from 0 to {pieces.end_s} s")


class Timing:
    """Starts of the pieces and requested times: the inputs of a plan apart from the heights."""

    def __init__(self, pieces: Pieces, t_s: ArrayLike) -> None:
        self.pieces, self.t_s = pieces, np.asarray(t_s, dtype=np.float64)
        self.has_slope = bool(np.count_nonzero(pieces.slopes_v_per_s))
        self._key = (
            self.has_slope, pieces.end_s, pieces.starts_s.tobytes(), pieces.frequencies_hz.tobytes(),
            self.t_s.shape, self.t_s.tobytes(),
        )  # fmt: skip

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Timing) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)


@lru_cache(maxsize=256)
def plan_of(timing: Timing, relaxations: Relaxations, system: LinearSystem) -> DrivenPlan:
    """Plan the nodes, decays, turns and flows of a timing."""
    check_times(timing.t_s, timing.pieces)
    nodes = nodes_of(timing.pieces, relaxations, timing.t_s)
    lengths = np.diff(nodes)
    _check_resolved(system, float(lengths.max(initial=0.0)))
    shared = phases(timing.pieces, relaxations, nodes)
    groups, kinds = _kinds(lengths, moving(shared.since, relaxations)[:-1])
    first = np.searchsorted(shared.piece, np.arange(shared.piece[-1] + 2))  # first node of each piece, and the end
    all_moving = (True,) * len(relaxations.rates_per_s)
    whole = Circuit(relaxations, tuple(timing.pieces.frequencies_hz.tolist()), timing.has_slope, all_moving)
    maps, drives = _maps(whole, system, groups)
    places = np.searchsorted(nodes, timing.t_s)
    return DrivenPlan(shared, places, first, whole.has_line, whole.has_slope, whole.output(), kinds, maps, drives)


def _check_resolved(system: LinearSystem, longest_s: float) -> None:
    fastest_hz = float(np.abs(np.linalg.eigvals(system.matrix)).max()) / (2 * np.pi)
    found = f"a frequency of up to {fastest_hz:.3g} Hz with times up to {longest_s:.3g} s apart"
    expected = f"a product of at most {CYCLES_MAX:.0e}; use a heavier, softer or less damped finger"
    require.expect(fastest_hz * longest_s <= CYCLES_MAX * (1 + 1e-9), "finger", found, expected)


def _maps(whole: Circuit, system: LinearSystem, groups: Sequence[Kind]) -> tuple[FloatArray, FloatArray]:
    """Return the state maps and quadratic forms of each interval kind."""
    n, n_states = len(system.input), whole.n_states
    maps, drives = np.zeros((len(groups), n, n)), np.zeros((len(groups), n, n_states, n_states))
    for active in {moves for _, moves in groups}:
        alike = [kind for kind, (_, moves) in enumerate(groups) if moves == active]
        circuit = replace(whole, active=active)
        result = flows(circuit, system, np.array([groups[kind][0] for kind in alike]))
        kept = circuit.active_places()
        maps[alike] = result.states
        drives[np.ix_(np.array(alike), np.arange(n), kept, kept)] = result.forms
    return maps, drives


def _kinds(lengths: FloatArray, moves: NDArray[np.bool_]) -> tuple[list[Kind], IndexArray]:
    """Group intervals by equal length and equal moving relaxations."""
    # equal time steps differ by rounding: compare leading digits and power of ten
    scale = 10.0 ** np.floor(np.log10(lengths))
    keys = np.column_stack([np.round(lengths / scale, 11), scale, moves])
    _, first, kinds = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    means = np.bincount(kinds, lengths) / np.bincount(kinds)
    return [(float(means[k]), tuple(moves[i].tolist())) for k, i in enumerate(first)], kinds
