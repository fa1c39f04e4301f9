"""A linear system driven by the square of a circuit's voltage, by one matrix exponential per length of time.

The products of the circuit's states obey linear equations with constant coefficients, so that products, driven
states and a constant together do too (a lift): the flow over any length is one exponential, whatever the time
constants.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.linalg import expm

from ...arrays import FloatArray, IndexArray
from .circuit import Circuit


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
