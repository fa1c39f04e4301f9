"""Integrals of cubic splines and rising fits: scipy.interpolate and scipy.optimize are slow to load."""

from functools import cache

import numpy as np

from ..arrays import Array

FINE = 40
"""Places between two nodes at which an integral is known."""


@cache
def spline_integral(n_nodes: int) -> tuple[Array, Array]:
    """Return places on the nodes 0, 1, ... and the weights (n_nodes, n_places) of the integrals up to them.

    The integral is that of the cubic spline through the values at four nodes or more, without a knot at the second
    and the second to last node.

    >>> places, weights = spline_integral(5)
    >>> bool(np.allclose(np.arange(5.0) ** 3 @ weights, places**4 / 4))
    True
    """
    values, moments = np.eye(n_nodes), _second_derivatives(n_nodes)
    steps = (values[:-1] + values[1:]) / 2 - (moments[:-1] + moments[1:]) / 24
    before = np.concatenate([np.zeros((1, n_nodes)), steps.cumsum(axis=0)])
    places = np.linspace(0, n_nodes - 1, FINE * n_nodes)
    node = np.minimum(places.astype(np.intp), n_nodes - 2)
    t = (places - node)[:, None]
    integral = before[node] + values[node] * (t - t**2 / 2) + values[node + 1] * t**2 / 2
    integral -= moments[node] * (t**2 - t**3 + t**4 / 4) / 6 + moments[node + 1] * (t**2 / 2 - t**4 / 4) / 6
    weights = np.ascontiguousarray(integral.T)
    for shared in (places, weights):
        shared.setflags(write=False)
    return places, weights


def _second_derivatives(n_nodes: int) -> Array:
    """Return the matrix that maps a spline's values to its second derivatives at the nodes."""
    inner = np.arange(1, n_nodes - 1)
    left, right = np.zeros((2, n_nodes, n_nodes))
    for offset, of_moment, of_value in ((-1, 1, 6), (0, 4, -12), (1, 1, 6)):
        left[inner, inner + offset], right[inner, inner + offset] = of_moment, of_value
    left[0, :3] = left[-1, -3:] = 1, -2, 1
    return np.asarray(np.linalg.solve(left, right), dtype=np.float64)


def rising_fit(values: Array, weights: Array) -> Array:
    """Return the rising sequence nearest to the values (n,) by weighted squares (pool adjacent violators).

    >>> rising_fit(np.array([1.0, 3.0, 2.0, 4.0]), np.array([1.0, 1.0, 3.0, 1.0])).tolist()
    [1.0, 2.25, 2.25, 4.0]
    """
    blocks: list[tuple[float, float, int]] = []
    for value, weight in zip(values.tolist(), weights.tolist(), strict=True):
        mean, total, size = value, weight, 1
        while blocks and blocks[-1][0] >= mean:
            before, its_total, its_size = blocks.pop()
            mean = (before * its_total + mean * total) / (its_total + total)
            total, size = total + its_total, size + its_size
        blocks.append((mean, total, size))
    means, _, sizes = zip(*blocks, strict=True)
    return np.repeat(means, sizes)
