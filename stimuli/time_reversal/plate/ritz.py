"""Ritz modes of a rectangle with any edges, in parity blocks.

K v = lambda M v is inverted to M v = theta (K + s M) v with theta = 1 / (lambda + s). The wanted low modes are then the
largest eigenvalues and keep all digits, while `eigh(K, M)` has errors of eps * lambda_max / lambda_1. Basis: `axis`.
Products i, j are kept where (i / p_x)^2 + (j / p_y)^2 <= 1. Checked against converged values of the literature in
`tests/stimuli/time_reversal/test_ritz.py`.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import product
from typing import Final

import numpy as np

from ...arrays import FloatArray, IntArray
from .rectangle import Family, Rectangle, families

SHIFT: Final = 1.0
"""Shift of the eigenvalues, in units of (2 / length)^4, which makes theta of rigid motions finite."""


@dataclass(frozen=True, eq=False)
class ParityBlock:
    """The modes of one pair of parities.

    `vectors` (n_modes, n_products) are the coefficients of the products of function `i` of x and `j` of y. Every mode
    has mean square 1 over the plate.
    """

    on_x: Family
    on_y: Family
    i: IntArray
    j: IntArray
    wavenumber2_per_m2: FloatArray
    vectors: FloatArray


@lru_cache(maxsize=16)
def solve(rectangle: Rectangle, wavenumber2_max_per_m2: float, degrees: tuple[int, int]) -> Sequence[ParityBlock]:
    """Return the Ritz modes up to a squared wavenumber; caches the last call."""
    blocks = [
        _block(rectangle, wavenumber2_max_per_m2, on_x, on_y, degrees) for on_x, on_y in pairs(rectangle, degrees)
    ]
    return _without_rigid_noise(blocks, rectangle.n_rigid)


def pairs(rectangle: Rectangle, degrees: tuple[int, int]) -> list[tuple[Family, Family]]:
    """Yield the functions of x and y for each pair of parities."""
    p_x, p_y = degrees
    on_x = families(rectangle.length_m, rectangle.edges_x, p_x)
    on_y = families(rectangle.width_m, rectangle.edges_y, p_y)
    return list(product(on_x, on_y))


def _block(
    rectangle: Rectangle, wavenumber2_max_per_m2: float, on_x: Family, on_y: Family, degrees: tuple[int, int]
) -> ParityBlock:
    i, j = ellipse(on_x, on_y, *degrees)
    stiffness, mass = pencil(rectangle, on_x, on_y, i, j)
    unit_per_m2 = 4 / rectangle.length_m**2
    highest = (wavenumber2_max_per_m2 / unit_per_m2) ** 2
    theta, vectors = _largest(mass, stiffness + SHIFT * mass, 1 / (highest + SHIFT))
    eigenvalue = np.maximum(1 / theta - SHIFT, 0.0)  # rounding may make a rigid motion negative
    # a mean square of 1 over the plate is 1 / 4 in s, which runs from -1 to 1 on both axes
    return ParityBlock(on_x, on_y, i, j, unit_per_m2 * np.sqrt(eigenvalue), 2 * _orthonormal(vectors, mass))


def ellipse(on_x: Family, on_y: Family, p_x: int, p_y: int) -> tuple[IntArray, IntArray]:
    """Return a mask of the kept products, (i / p_x)^2 + (j / p_y)^2 <= 1."""
    inside = (on_x.order[:, None] / p_x) ** 2 + (on_y.order[None, :] / p_y) ** 2 <= 1
    i, j = np.nonzero(inside)
    return i, j


def pencil(rectangle: Rectangle, on_x: Family, on_y: Family, i: IntArray, j: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return stiffness and mass in units of (length / 2)^4 k^4."""
    from scipy.sparse import csr_array, kron

    r2 = (rectangle.length_m / rectangle.width_m) ** 2  # factor of two derivatives along y, in units of half the length
    nu = rectangle.poisson_ratio
    x = {name: csr_array(matrix) for name, matrix in _integrals(on_x).items()}
    y = {name: csr_array(matrix) for name, matrix in _integrals(on_y).items()}
    twist = kron(x["cross"], y["cross"].T) + kron(x["cross"].T, y["cross"])
    stiffness = kron(x["stiffness"], y["mass"]) + r2**2 * kron(x["mass"], y["stiffness"])
    stiffness = stiffness + r2 * (nu * twist + 2 * (1 - nu) * kron(x["slope"], y["slope"]))
    chosen = i * on_y.n + j  # row of a product in `kron`
    cut = [csr_array(whole)[chosen][:, chosen].toarray() for whole in (stiffness, kron(x["mass"], y["mass"]))]
    return cut[0], cut[1]


def _integrals(family: Family) -> dict[str, FloatArray]:
    return {
        "stiffness": family.gram("curvature_in_s", "curvature_in_s"),
        "mass": family.gram("function", "function"),
        "slope": family.gram("slope", "slope"),
        "cross": family.gram("curvature_in_s", "function"),
    }


def _largest(mass: FloatArray, shifted: FloatArray, theta_min: float) -> tuple[FloatArray, FloatArray]:
    """Return eigenvalues theta >= theta_min of M v = theta A v, descending."""
    from scipy.linalg import cholesky, eigh, solve_triangular

    lower = cholesky(shifted, lower=True, check_finite=False)
    half = solve_triangular(lower, mass, lower=True, check_finite=False)
    reduced = solve_triangular(lower, half.T, lower=True, check_finite=False)
    theta, turned = eigh(
        reduced,
        subset_by_value=(theta_min * (1 - 1e-9), np.inf),  # include a mode at the limit
        driver="evr",
        overwrite_a=True,
        check_finite=False,
    )
    vectors = solve_triangular(lower, turned, lower=True, trans="T", check_finite=False)
    return theta[::-1], vectors.T[::-1]


def _orthonormal(vectors: FloatArray, mass: FloatArray) -> FloatArray:
    """Return the modes orthonormalised by one Cholesky step."""
    from scipy.linalg import cholesky, solve_triangular

    if len(vectors) == 0:
        return vectors
    scaled = vectors / np.sqrt(np.einsum("np,np->n", vectors, vectors @ mass))[:, None]
    gram = cholesky(scaled @ mass @ scaled.T, lower=True)
    return np.asarray(solve_triangular(gram, scaled, lower=True))


def _without_rigid_noise(blocks: list[ParityBlock], n_zero: int) -> list[ParityBlock]:
    """Set the wavenumbers of the known rigid-body modes to 0."""
    if n_zero == 0:
        return blocks
    ascending = np.sort(np.concatenate([block.wavenumber2_per_m2 for block in blocks]))
    largest_rigid = ascending[:n_zero].max(initial=0.0)
    k2s = [np.where(block.wavenumber2_per_m2 <= largest_rigid, 0.0, block.wavenumber2_per_m2) for block in blocks]
    return [replace(block, wavenumber2_per_m2=k2) for block, k2 in zip(blocks, k2s, strict=True)]
