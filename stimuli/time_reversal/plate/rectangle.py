"""Axis functions of modes: sines and integrated Legendre functions.

Every evaluation is a sine or a three-term Legendre recurrence, which keep 14 digits at any order. There are no
differences of hyperbolic functions. With P_k orthonormal on [-1, 1], the functions B_k with B_k'' = P_k have the unit
matrix as bending stiffness and a pentadiagonal mass matrix. They are well conditioned at any degree, while monomials
fail from degree 20 on. For k >= 2, B_k and its slope vanish at both ends; the cubics 1, s, B_0, B_1 satisfy the edge
conditions.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from ...arrays import FloatArray, IntArray


class Axis(Protocol):
    """A set of n functions of one coordinate; each method returns (n, n_points)."""

    def value(self, at_m: ArrayLike) -> FloatArray: ...

    def curvature(self, at_m: ArrayLike) -> FloatArray:
        """Return second derivatives."""

    def integral(self, start_m: ArrayLike, stop_m: ArrayLike) -> FloatArray:
        """Return integrals from start to stop."""

    def curvature_integral(self, start_m: ArrayLike, stop_m: ArrayLike) -> FloatArray:
        """Return integrals of the second derivatives from start to stop."""


@dataclass(frozen=True)
class SineAxis:
    """Functions sqrt(2) sin(i pi x / length), i = 1..n, for two simply supported ends; mean square 1."""

    length_m: float
    n: int

    @property
    def wavenumber_rad_per_m(self) -> FloatArray:
        return np.asarray(np.arange(1, self.n + 1) * (math.pi / self.length_m), float)

    def value(self, at_m: ArrayLike) -> FloatArray:
        """Evaluate from the nearer end: both ends are exact zeros, mirror images are equal."""
        at = np.atleast_1d(np.asarray(at_m, float)) / self.length_m
        order = np.arange(1, self.n + 1)[:, None]
        far = at > 0.5
        from_nearer = np.where(far, 1 - at, at)
        sign = np.where(far & (order % 2 == 0), -1.0, 1.0)  # even orders are odd about the middle
        return np.asarray(math.sqrt(2) * sign * np.sin(order * math.pi * from_nearer), float)

    def curvature(self, at_m: ArrayLike) -> FloatArray:
        return -(self.wavenumber_rad_per_m[:, None] ** 2) * self.value(at_m)

    def integral(self, start_m: ArrayLike, stop_m: ArrayLike) -> FloatArray:
        """Return (b - a) times the middle value times sinc, which avoids the cancellation of cos - cos."""
        start, stop = np.atleast_1d(start_m), np.atleast_1d(stop_m)
        half = self.wavenumber_rad_per_m[:, None] * (stop - start) / 2
        return np.asarray(self.value((start + stop) / 2) * (stop - start) * np.sinc(half / math.pi))

    def curvature_integral(self, start_m: ArrayLike, stop_m: ArrayLike) -> FloatArray:
        return np.asarray(-(self.wavenumber_rad_per_m[:, None] ** 2) * self.integral(start_m, stop_m))


@dataclass(frozen=True, eq=False)
class LegendreAxis:
    """Polynomials given by their coefficients on orthonormal Legendre polynomials of s = 2 x / length - 1.

    Parameters
    ----------
    length_m : float
    function, slope, curvature_in_s : (n, degree + 1) arrays
        Coefficients of the functions and of their derivatives with respect to s.
    """

    length_m: float
    function: FloatArray
    slope: FloatArray
    curvature_in_s: FloatArray

    def value(self, at_m: ArrayLike) -> FloatArray:
        return self.function @ self._legendre(at_m)

    def curvature(self, at_m: ArrayLike) -> FloatArray:
        return (2 / self.length_m) ** 2 * (self.curvature_in_s @ self._legendre(at_m))

    def integral(self, start_m: ArrayLike, stop_m: ArrayLike) -> FloatArray:
        return self._quadrature(self.function, start_m, stop_m)

    def curvature_integral(self, start_m: ArrayLike, stop_m: ArrayLike) -> FloatArray:
        return (2 / self.length_m) ** 2 * self._quadrature(self.curvature_in_s, start_m, stop_m)

    def _legendre(self, at_m: ArrayLike) -> FloatArray:
        # rounding may move a point beyond its edge, where polynomials of high degree are large
        s = np.clip(2 * np.atleast_1d(np.asarray(at_m, float)) / self.length_m - 1, -1.0, 1.0)
        return orthonormal_legendre(s, self.function.shape[1] - 1)

    def _quadrature(self, coefficients: FloatArray, start_m: ArrayLike, stop_m: ArrayLike) -> FloatArray:
        """Integrate by Gauss's rule, exact for this degree at any interval."""
        start, stop = np.atleast_1d(start_m), np.atleast_1d(stop_m)
        # n nodes are exact up to degree 2 n - 1
        nodes, weights = np.polynomial.legendre.leggauss(coefficients.shape[1] // 2 + 1)
        half = (stop - start) / 2
        at = ((start + stop) / 2 + half * nodes[:, None]).ravel()
        values = (coefficients @ self._legendre(at)).reshape(-1, nodes.size, half.size)
        return np.asarray(np.einsum("w,iwp->ip", weights, values) * half)


def orthonormal_legendre(s: FloatArray, degree: int) -> FloatArray:
    """Return sqrt(k + 1/2) P_k(s) for k = 0..degree by the three-term recurrence, (degree + 1, n_points)."""
    scale = np.sqrt(np.arange(degree + 1) + 0.5)
    return np.ascontiguousarray((np.polynomial.legendre.legvander(s, degree) * scale).T)


N_CUBICS = 4


@dataclass(frozen=True, eq=False)
class Family:
    """Functions of one parity (-1: no parity), with the degrees used to truncate products."""

    axis: LegendreAxis
    order: IntArray

    @property
    def n(self) -> int:
        return len(self.order)

    def gram(self, left: str, right: str) -> FloatArray:
        """Return exact integrals of products of ``function``, ``slope`` etc."""
        first: FloatArray = getattr(self.axis, left)
        second: FloatArray = getattr(self.axis, right)
        return first @ second.T


def families(length_m: float, edges: str, degree: int) -> list[Family]:
    """Return functions up to `degree`, split by parity if both edges are equal.

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
    # each condition removes one cubic; the remaining ones count as the highest degrees
    order = np.array([*cubics[len(cubics) - len(mixing) :], *inner])
    return Family(LegendreAxis(length_m, *rows), order)


def _integrals(degree: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return coefficients of 1, s and B_0.. and of their first two derivatives; row i has degree i."""
    k = np.arange(1, degree + 1)
    # the integral of P_(k-1) combines P_k and P_(k-2)
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
    """Return rows that combine cubics to meet the edge conditions, with orthonormal curvature."""
    ends = orthonormal_legendre(np.array([-1.0, 1.0]), function.shape[1] - 1)
    value_at, slope_at = function @ ends, slope @ ends
    conditions = [value_at[:, i] for i in (0, 1) if edges[i] in "SC"]
    conditions += [slope_at[:, i] for i in (0, 1) if edges[i] == "C"]
    free = np.eye(len(function))
    if conditions:
        _, singular, rows = np.linalg.svd(np.array(conditions))
        free = rows[int(np.sum(singular > 1e-9 * singular.max())) :]
    bent = free @ curvature
    stiffness, turn = np.linalg.eigh(bent @ bent.T)
    # linear functions have no bending stiffness to scale with
    scale = np.where(stiffness > 1e-9, 1 / np.sqrt(np.maximum(stiffness, 1e-9)), 1.0)
    return scale[:, None] * (turn.T @ free)


@dataclass(frozen=True)
class Rectangle:
    """A rectangle from 0 to length in x and 0 to width in y, with its edges.

    Parameters
    ----------
    length_m, width_m : float
        Side lengths, above 0.
    boundary : str
        Four letters, S (simply supported), C (clamped) or F (free), for x = 0, y = 0, x = length, y = width.
    poisson_ratio : float
        Poisson ratio, which affects the mode shapes at free edges only.
    """

    length_m: float
    width_m: float
    boundary: str
    poisson_ratio: float

    @property
    def edges_x(self) -> str:
        """Edge conditions at x = 0 and x = length."""
        return self.boundary[::2]

    @property
    def edges_y(self) -> str:
        return self.boundary[1::2]

    @property
    def n_rigid(self) -> int:
        """Number of rigid-body motions that the edges permit.

        >>> [Rectangle(0.3, 0.2, boundary, 0.3).n_rigid for boundary in ("FFFF", "SFFF", "SFSF", "CFFF")]
        [3, 1, 0, 0]
        """
        edges = (self.edges_x, self.edges_y)
        constant = [pair == "FF" for pair in edges]
        linear = ["C" not in pair and pair.count("S") <= 1 for pair in edges]
        return constant[0] * constant[1] + linear[0] * constant[1] + constant[0] * linear[1]


class Sines(NamedTuple):
    """Modes with `m` half-waves along x and `n` along y, each from 1, by ascending `wavenumber2_per_m2`."""

    m: IntArray
    n: IntArray
    wavenumber2_per_m2: FloatArray


def sines(rectangle: Rectangle, wavenumber2_max_per_m2: float) -> Sines:
    """Return modes up to a squared wavenumber (m pi / a)^2 + (n pi / b)^2.

    >>> sines(Rectangle(2.0, 1.0, "SSSS", 0.3), 5 * np.pi**2).m
    array([1, 2, 3, 1, 2, 4])
    """
    sides = (rectangle.length_m, rectangle.width_m)
    along_x, along_y = (np.arange(1, int(side * math.sqrt(wavenumber2_max_per_m2) / math.pi) + 2) for side in sides)
    k2 = (math.pi * along_x[:, None] / sides[0]) ** 2 + (math.pi * along_y[None, :] / sides[1]) ** 2
    # include a mode at the limit despite rounding
    m, n = np.nonzero(k2 <= wavenumber2_max_per_m2 * (1 + 1e-12))
    order = np.argsort(k2[m, n], kind="stable")
    return Sines(along_x[m[order]], along_y[n[order]], k2[m, n][order])
