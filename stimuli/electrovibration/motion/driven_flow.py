"""A linear system driven by the square of a circuit's voltage: its exact flow over any length of time.

The circuit's states under a line and sinusoids are one linear equation, ``z' = Z z``, so that the voltage is a linear
form of them and the driven states at the end of an interval are quadratic forms of those at its start. Both follow from
their power series over a short time, doubled as often as it takes (the squaring of a matrix exponential: Moler and Van
Loan, SIAM Review 45, 3, 2003).
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from ...arrays import FloatArray, IndexArray
from ..skin.relaxation import Relaxations

REACH: Final = 0.5
"""The longest time of the series in units of the fastest rate."""
TERMS: Final = 20
"""Of the series: 0.5^21/21! = 1e-26 is left out."""


@dataclass(frozen=True)
class Circuit:
    """Which states the circuit has: relaxations, line, sinusoids; `active` says which relaxations still move.

    States in order: active relaxations; value of the line (if it counts); slope of the line (if any); for each
    frequency real and imaginary part of ``c exp(2 pi i f t)``.
    """

    relaxations: Relaxations
    frequencies_hz: tuple[float, ...]
    has_slope: bool
    active: tuple[bool, ...]

    @property
    def has_line(self) -> bool:
        return self.relaxations.dc_gain != 0

    def matrix(self) -> FloatArray:
        """(n_states, n_states) of their linear equation."""
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
        """(n_states,) linear form that gives the voltage whose square is the force."""
        r = self.relaxations
        moving = [gain for gain, moves in zip(r.gains, self.active, strict=True) if moves]
        still = [(gain, rate) for gain, rate, m in zip(r.gains, r.rates_per_s, self.active, strict=True) if not m]
        # one that is still follows its input: a slope gives slope/rate, a sinusoid its response
        line = [r.dc_gain] if self.has_line else []
        slope = [sum(gain / rate for gain, rate in still)] if self.has_slope else []
        turns = Relaxations(tuple(g for g, _ in still), tuple(s for _, s in still), r.dc_gain)
        responses = [(h.real, -h.imag) for h in turns.response(self.frequencies_hz)]
        return np.array([*moving, *line, *slope, *(x for pair in responses for x in pair)])

    @property
    def n_states(self) -> int:
        return sum(self.active) + self.has_line + self.has_slope + 2 * len(self.frequencies_hz)

    def active_places(self) -> IndexArray:
        """(n_states,) their places among the states of the circuit with all relaxations moving."""
        n_all = len(self.active) + self.n_states - sum(self.active)
        return np.flatnonzero([*self.active, *([True] * (n_all - len(self.active)))])


@dataclass(frozen=True)
class LinearSystem:
    """``x' = M x + b F``, M (n, n) and b (n,) as tuples."""

    matrix: tuple[tuple[float, ...], ...]
    input: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class Flows:
    """``x_a(t + h) = sum_b states_ab x_b(t) + sum_ij forms_aij z_i(t) z_j(t)`` for lengths h, for 1 N/V^2.

    `states` (n_lengths, n, n) and `forms` (n_lengths, n, n_states, n_states) of a circuit with n_states; `change`
    (n_lengths, n_states, n_states) are the maps of its own states less the identity, beside which a short turn of
    phase would lose its digits.
    """

    states: FloatArray
    forms: FloatArray
    change: FloatArray

    def twice(self) -> "Flows":
        """Over lengths twice as long: the first half moves on, the second begins where the circuit is then."""
        over = (np.eye(self.change.shape[-1]) + self.change)[:, None]
        forms = np.einsum("lab,lbij->laij", self.states, self.forms) + over.swapaxes(-1, -2) @ self.forms @ over
        return Flows(self.states @ self.states, forms, 2 * self.change + self.change @ self.change)


def flows(circuit: Circuit, system: LinearSystem, lengths_s: FloatArray) -> Flows:
    """The exact flows over lengths of time (n_lengths,) above 0."""
    fastest_per_s = _fastest_per_s(circuit, system)
    doublings = np.maximum(0, np.ceil(np.log2(fastest_per_s * lengths_s / REACH))).astype(np.intp)
    flow = _short_flows(circuit, system, fastest_per_s, np.ldexp(fastest_per_s * lengths_s, -doublings))
    for done in range(doublings.max(initial=0)):
        on = doublings > done
        longer = Flows(flow.states[on], flow.forms[on], flow.change[on]).twice()
        flow.states[on], flow.forms[on], flow.change[on] = longer.states, longer.forms, longer.change
    return flow


def _fastest_per_s(circuit: Circuit, system: LinearSystem) -> float:
    """A bound of the rates of products of the circuit's states and of the driven states, above 0."""
    electric, driven = (np.abs(np.linalg.eigvals(m)).max(initial=0.0) for m in (circuit.matrix(), system.matrix))
    return float(2 * electric + driven) or 1.0


def _short_flows(circuit: Circuit, system: LinearSystem, unit_per_s: float, lengths: FloatArray) -> Flows:
    """Power series in lengths (n_lengths,) of up to `REACH`, in times of 1/unit_per_s."""
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
    """`TERMS` of them, each derived from the one before it."""
    found = [first]
    while len(found) < TERMS:
        found.append(derive(found[-1]))
    return found
