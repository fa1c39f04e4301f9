"""A linear system driven by the square of a circuit's voltage, by one matrix exponential per length of time.

The products of the circuit's states obey linear equations with constant coefficients, so that products, driven
states and a constant together do too (a lift): the flow over any length is one exponential, whatever the time
constants. The circuit's states under a line and sinusoids are one linear equation themselves.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.linalg import expm

from ...arrays import FloatArray, IndexArray
from ..skin.relaxation import Relaxations


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
class Flow:
    """``x(t + h) = states x + products P(t)``, P the products of the circuit's states, for 1 N/V^2."""

    states: FloatArray
    products: FloatArray


@lru_cache(maxsize=4096)
def flow(circuit: Circuit, system: LinearSystem, length_s: float) -> Flow:
    """The exact flow over a length of time."""
    n = len(system.input)
    rows = expm(lifted_matrix(circuit, system) * length_s)[-n:]
    return Flow(rows[:, -n:].copy(), rows[:, :-n].copy())


def lifted_matrix(circuit: Circuit, system: LinearSystem) -> FloatArray:
    """Of the states (products, driven states)."""
    g, n = circuit.output(), len(system.input)
    n_products = pairs(len(g))[0].size
    lift = np.zeros((n_products + n, n_products + n))
    lift[:n_products, :n_products] = product_matrix(circuit.matrix())
    lift[n_products:, :n_products] = np.outer(system.input, _square_form(g))
    lift[n_products:, n_products:] = system.matrix
    return lift


def pairs(n: int) -> tuple[IndexArray, IndexArray]:
    """The products ``z_i z_j`` with ``i <= j``, in order."""
    return np.triu_indices(n)


def _square_form(g: FloatArray) -> FloatArray:
    """The linear form on the products that is ``(g z)^2``."""
    i, j = pairs(len(g))
    times = np.where(i == j, 1.0, 2.0)  # z_i z_j stands for z_j z_i too
    return np.asarray(g[i] * g[j] * times)


def product_matrix(z: FloatArray) -> FloatArray:
    """The linear equation of the products, from ``(z_i z_j)' = (Z z)_i z_j + z_i (Z z)_j``."""
    n = len(z)
    i, j = pairs(n)
    column = np.zeros((n, n), dtype=np.intp)
    column[i, j] = column[j, i] = np.arange(i.size)
    lift = np.zeros((i.size, i.size))
    rows = np.arange(i.size)
    for other in range(n):
        lift[rows, column[other, j]] += z[i, other]
        lift[rows, column[i, other]] += z[j, other]
    return lift
