"""Twice-integrated Legendre functions that meet the essential conditions of an edge.

With P_k orthonormal on [-1, 1], the functions B_k with B_k'' = P_k have the unit matrix as bending
stiffness and a pentadiagonal mass: well conditioned at any degree, where monomials fail from degree 20 on.
B_k vanishes with its slope at both ends for k >= 2; the cubics 1, s, B_0, B_1 carry the edges.
"""

from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray, IntArray
from .axis import LegendreAxis, orthonormal_legendre

N_CUBICS = 4


@dataclass(frozen=True, eq=False)
class Family:
    """Functions of one parity (or of none, `parity` = -1) with the degree order used to truncate products."""

    axis: LegendreAxis
    order: IntArray

    @property
    def n(self) -> int:
        return len(self.order)

    def gram(self, left: str, right: str) -> FloatArray:
        """Integral over s of two of ``function``, ``slope``, ``curvature_in_s``, exact by orthonormality."""
        first: FloatArray = getattr(self.axis, left)
        second: FloatArray = getattr(self.axis, right)
        return first @ second.T


def families(length_m: float, edges: str, degree: int) -> list[Family]:
    """The functions up to `degree` for the two edges, split into even and odd where both edges are alike.

    Parameters
    ----------
    length_m : float
    edges : str
        Two of S, C, F: the edge at 0 and the edge at the length.
    degree : int
        At least 4.
    """
    parities = [0, 1] if edges[0] == edges[1] else [-1]
    return [_family(length_m, edges, degree, parity) for parity in parities]


def _family(length_m: float, edges: str, degree: int, parity: int) -> Family:
    function, slope, curvature = _integrals(degree)
    cubics = [i for i in range(N_CUBICS) if parity < 0 or i % 2 == parity]
    inner = [i for i in range(N_CUBICS, degree + 1) if parity < 0 or i % 2 == parity]
    mixing = _admissible(function[cubics], slope[cubics], curvature[cubics], edges)
    rows = [np.vstack([mixing @ table[cubics], table[inner]]) for table in (function, slope, curvature)]
    # each condition takes one cubic away; what is left counts with the highest degrees
    order = np.array([*cubics[len(cubics) - len(mixing) :], *inner])
    return Family(LegendreAxis(length_m, *rows), order)


def _integrals(degree: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Coefficients of 1, s and B_0.. with their first and second derivatives; row i has degree i."""
    k = np.arange(1, degree + 1)
    # the integral of P_(k-1) is a part of P_k minus a part of P_(k-2)
    integrate = np.zeros((degree + 1, degree + 1))
    integrate[k - 1, k] = 1 / np.sqrt(4.0 * k**2 - 1)
    integrate[k, k - 1] = -1 / np.sqrt(4.0 * k**2 - 1)
    curvature = np.eye(degree + 1, k=-2)
    slope = curvature @ integrate
    function = slope @ integrate
    function[0, 0] = function[1, 1] = 1.0
    slope[1, 0] = np.sqrt(3.0)
    return function, slope, curvature


def _admissible(function: FloatArray, slope: FloatArray, curvature: FloatArray, edges: str) -> FloatArray:
    """Rows that mix the cubics into functions that meet the conditions, with orthonormal second
    derivatives.
    """
    ends = orthonormal_legendre(np.array([-1.0, 1.0]), function.shape[1] - 1)
    value_at, slope_at = function @ ends, slope @ ends
    conditions = [value_at[:, i] for i in (0, 1) if edges[i] in "SC"]
    conditions += [slope_at[:, i] for i in (0, 1) if edges[i] == "C"]
    free = _null_rows(np.array(conditions).reshape(-1, len(function)))
    bent = free @ curvature
    stiffness, turn = np.linalg.eigh(bent @ bent.T)
    # straight functions have no bending stiffness to be scaled by
    scale = np.where(stiffness > 1e-9, 1 / np.sqrt(np.maximum(stiffness, 1e-9)), 1.0)
    return scale[:, None] * (turn.T @ free)


def _null_rows(conditions: FloatArray) -> FloatArray:
    if conditions.size == 0:
        return np.eye(conditions.shape[1])
    _, singular, rows = np.linalg.svd(conditions)
    return rows[int(np.sum(singular > 1e-9 * singular.max())) :]
