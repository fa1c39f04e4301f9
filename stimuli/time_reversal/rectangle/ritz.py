"""Modes of a plate with any edges by Rayleigh and Ritz, solved for 1/lambda in parity blocks.

K v = lambda M v is turned round, M v = theta (K + s M) v with theta = 1 / (lambda + s): the wanted low
modes are then the largest eigenvalues and keep all their digits, where `eigh(K, M)` loses them to eps *
lambda_max / lambda_1. Basis: `legendre`. Products i, j are kept where (i / p_x)^2 + (j / p_y)^2 <= 1.
Checked against converged values of the literature in `tests/stimuli/time_reversal/test_ritz.py`.
"""

import math
from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tactometry.errors import InvalidParameter

from ..plate.plate import Plate
from .legendre import Family, families, n_rigid

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

MARGIN_DEGREES: Final = 20
MAX_FUNCTIONS: Final = 16_000
SHIFT: Final = 1.0


@dataclass(frozen=True, eq=False)
class ParityBlock:
    """The modes of one pair of parities.

    `vectors` (n_modes, n_products) hold the coefficients of the products of function `i` of x and `j` of y;
    the mean square of every mode over the plate is 1.
    """

    on_x: Family
    on_y: Family
    i: IntArray
    j: IntArray
    angular_frequency_rad_per_s: FloatArray
    vectors: FloatArray


def degrees(plate: Plate, f_max_hz: float) -> tuple[int, int]:
    """Degree of x and of y that holds the frequencies below `f_max_hz`: half a side times wavenumber,
    and 20 more.
    """
    half_k = math.sqrt(2 * math.pi * f_max_hz / plate.wave_constant_m2_per_s) / 2
    p_x, p_y = (math.ceil(half_k * side) + MARGIN_DEGREES for side in (plate.length_m, plate.width_m))
    if math.pi / 4 * p_x * p_y > MAX_FUNCTIONS:
        raise InvalidParameter(
            f"f_max_hz: found {f_max_hz}, which needs {p_x} x {p_y} functions, more than can be held; "
            "lower f_max_hz or use the simply supported plate"
        )
    return p_x, p_y


def solve(plate: Plate, f_max_hz: float, degree: tuple[int, int] | None = None) -> list[ParityBlock]:
    """The modes up to `f_max_hz` as one block per pair of parities.

    Parameters
    ----------
    degree : (int, int), optional
        Polynomial degrees in x and y; by default `degrees`.
    """
    edges_x, edges_y = plate.boundary[::2], plate.boundary[1::2]
    p_x, p_y = degree or degrees(plate, f_max_hz)
    pairs = product(families(plate.length_m, edges_x, p_x), families(plate.width_m, edges_y, p_y))
    blocks = [_block(plate, f_max_hz, on_x, on_y, (p_x, p_y)) for on_x, on_y in pairs]
    return _without_rigid_noise(blocks, n_rigid(edges_x, edges_y))


def _block(plate: Plate, f_max_hz: float, on_x: Family, on_y: Family, degree: tuple[int, int]) -> ParityBlock:
    i, j = ellipse(on_x, on_y, *degree)
    stiffness, mass = pencil(plate, on_x, on_y, i, j)
    unit = 4 * plate.wave_constant_m2_per_s / plate.length_m**2
    theta, vectors = _largest(mass, stiffness + SHIFT * mass, 1 / ((2 * math.pi * f_max_hz / unit) ** 2 + SHIFT))
    eigenvalue = np.maximum(1 / theta - SHIFT, 0.0)
    return ParityBlock(on_x, on_y, i, j, unit * np.sqrt(eigenvalue), 2 * _orthonormal(vectors, mass))


def ellipse(on_x: Family, on_y: Family, p_x: int, p_y: int) -> tuple[IntArray, IntArray]:
    """The products of functions that are kept: (i / p_x)^2 + (j / p_y)^2 <= 1 in degrees."""
    inside = (on_x.order[:, None] / p_x) ** 2 + (on_y.order[None, :] / p_y) ** 2 <= 1
    i, j = np.nonzero(inside)
    return i, j


def pencil(plate: Plate, on_x: Family, on_y: Family, i: IntArray, j: IntArray) -> tuple[FloatArray, FloatArray]:
    """Stiffness and mass in units of (length / 2)^4 k^4: the quadratic form of Kirchhoff's plate."""
    from scipy.sparse import csr_array, kron

    r2 = (plate.length_m / plate.width_m) ** 2
    nu = plate.poisson_ratio
    x = {name: csr_array(matrix) for name, matrix in _integrals(on_x).items()}
    y = {name: csr_array(matrix) for name, matrix in _integrals(on_y).items()}
    twist = kron(x["cross"], y["cross"].T) + kron(x["cross"].T, y["cross"])
    stiffness = kron(x["stiffness"], y["mass"]) + r2**2 * kron(x["mass"], y["stiffness"])
    stiffness = stiffness + r2 * (nu * twist + 2 * (1 - nu) * kron(x["slope"], y["slope"]))
    chosen = i * on_y.n + j
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
    """Eigenvalues theta >= theta_min of M v = theta A v, descending, and their vectors as rows."""
    from scipy.linalg import cholesky, eigh, solve_triangular

    lower = cholesky(shifted, lower=True, check_finite=False)
    half = solve_triangular(lower, mass, lower=True, check_finite=False)
    reduced = solve_triangular(lower, half.T, lower=True, check_finite=False)
    theta, turned = eigh(
        reduced,
        subset_by_value=(theta_min * (1 - 1e-9), np.inf),
        driver="evr",
        overwrite_a=True,
        check_finite=False,
    )
    vectors = solve_triangular(lower, turned, lower=True, trans="T", check_finite=False)
    return theta[::-1], vectors.T[::-1]


def _orthonormal(vectors: FloatArray, mass: FloatArray) -> FloatArray:
    """The same modes with V M V^T = 1 to rounding: one Cholesky step removes what the solver left."""
    from scipy.linalg import cholesky, solve_triangular

    if len(vectors) == 0:
        return vectors
    scaled = vectors / np.sqrt(np.einsum("np,np->n", vectors, vectors @ mass))[:, None]
    gram = cholesky(scaled @ mass @ scaled.T, lower=True)
    return np.asarray(solve_triangular(gram, scaled, lower=True))


def _without_rigid_noise(blocks: list[ParityBlock], n_zero: int) -> list[ParityBlock]:
    """Rigid-body modes are 0 Hz exactly: their number is known from the edges."""
    together = np.concatenate([block.angular_frequency_rad_per_s for block in blocks])
    for block in blocks if n_zero else []:
        ranks = np.searchsorted(np.sort(together), block.angular_frequency_rad_per_s, side="right")
        block.angular_frequency_rad_per_s[ranks <= n_zero] = 0.0
    return blocks
