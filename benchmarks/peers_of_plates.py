"""Settings of accuracy problems of plates with finite differences, finite elements and other bases."""

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.polynomial import Legendre, Polynomial
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import LinAlgError, eigh
from scipy.sparse.linalg import eigsh

from tactometry.experiments.accuracy.measure import Setting
from tactometry.experiments.accuracy.problems import plates
from tactometry.stimuli.time_reversal.plate.plate import Plate
from tactometry.stimuli.time_reversal.plate.rectangle import Family, LegendreAxis
from tactometry.stimuli.time_reversal.plate.ritz import ellipse, pencil

Real = NDArray[np.float64]
CELLS, ELEMENTS, DEGREES = (20, 40, 80, 160), (6, 10, 16, 24), (10, 12, 14, 18, 22, 26)


def simply_supported() -> list[Setting]:
    plate = plates.square("SSSS")
    n_modes = len(plate.frequencies_hz(plates.F_MAX_HZ))
    return [
        Setting(f"{n} x {n} cells", partial(_differences_hz, plate, n, n_modes), contender="finite differences")
        for n in CELLS
    ]


def _differences_hz(plate: Plate, n: int, n_modes: int) -> Real:
    """Return frequencies by finite differences.

    The squared five-point Laplacian is the plate's 13-point stencil with simply supported edges.
    """
    h = plate.length_m / n
    line = sparse.diags_array([1.0, -2.0, 1.0], offsets=[-1, 0, 1], shape=(n - 1, n - 1)) / h**2
    laplacian = sparse.kronsum(line, line, format="csc")
    lowest = eigsh(laplacian @ laplacian, n_modes, sigma=0.0, return_eigenvectors=False)
    return np.sort(plate.wave_constant_m2_per_s * np.sqrt(lowest) / (2 * math.pi))


def free() -> list[Setting]:
    plate = plates.square("FFFF")
    n_modes = len(plate.frequencies_hz(plates.F_MAX_HZ))
    return [
        Setting(f"{n} x {n} elements", partial(_elements_hz, plate, n, n_modes), contender="scikit-fem BFS")
        for n in ELEMENTS
    ]


def _elements_hz(plate: Plate, n: int, n_modes: int) -> Real:
    return bogner_fox_schmit_hz(plate, n, n, n_modes)[plate.rectangle.n_rigid :]


def bogner_fox_schmit_hz(plate: Plate, n_x: int, n_y: int, n_modes: int) -> NDArray[np.float64]:
    """Return frequencies by Bogner-Fox-Schmit elements with free edges.

    Shift-inverted Lanczos iteration finds them from Kirchhoff's bilinear form. The rigid modes come first.
    """
    from scipy.sparse.linalg import eigsh
    from skfem import Basis, BilinearForm, ElementQuadBFS, MeshQuad
    from skfem.helpers import dd, ddot, trace

    mesh = MeshQuad.init_tensor(np.linspace(0, plate.length_m, n_x + 1), np.linspace(0, plate.width_m, n_y + 1))
    basis, nu = Basis(mesh, ElementQuadBFS()), plate.poisson_ratio

    @BilinearForm
    def bending(u, v, w):  # type: ignore[no-untyped-def]
        del w
        return (1 - nu) * ddot(dd(u), dd(v)) + nu * trace(dd(u)) * trace(dd(v))

    @BilinearForm
    def inertia(u, v, w):  # type: ignore[no-untyped-def]
        del w
        return u * v

    lowest = eigsh(bending.assemble(basis), n_modes, inertia.assemble(basis), sigma=-1.0, return_eigenvectors=False)
    return np.sort(plate.wave_constant_m2_per_s * np.sqrt(np.maximum(lowest, 0)) / (2 * np.pi))


def other_bases() -> list[Setting]:
    kinds = {"monomials": Polynomial.basis, "Legendre, K v = l M v": _orthonormal}
    return [
        Setting(f"{p} x {p}", partial(_bare_hz, basis, p), contender=name)
        for name, basis in kinds.items()
        for p in DEGREES
    ]


def _orthonormal(k: int) -> Polynomial:
    return Legendre.basis(k).convert(kind=Polynomial) * math.sqrt(k + 0.5)


def _bare_hz(basis: Callable[[int], Polynomial], degree: int) -> Real:
    """Return frequencies from the same Rayleigh quotient with other basis functions, without preparation."""
    plate = plates.MIXED
    held = _family(plate.length_m, Polynomial([1, 0, -1]), [basis(k) for k in range(degree - 1)], 2)
    free = _family(plate.width_m, Polynomial([1]), [basis(k) for k in range(degree + 1)], 0)
    stiffness, mass = pencil(plate.rectangle, held, free, *ellipse(held, free, degree, degree))
    try:
        result = eigh(stiffness, mass, eigvals_only=True)
    except LinAlgError:
        return np.full(4, np.nan)
    unit_hz = 4 * plate.wave_constant_m2_per_s / plate.length_m**2 / (2 * math.pi)
    with np.errstate(invalid="ignore"):
        found_hz = unit_hz * np.sqrt(result)
    return found_hz[~(found_hz > plates.MIXED_TO_HZ)]


def _family(length_m: float, edge: Polynomial, functions: Sequence[Polynomial], first: int) -> Family:
    """Return `edge` times the functions, and their derivatives, as coefficients of orthonormal Legendre polynomials."""
    whole = [edge * function for function in functions]
    n = max(function.degree() for function in whole) + 1
    tables = [_on_legendre([each.deriv(k) for each in whole], n) for k in range(3)]
    return Family(LegendreAxis(length_m, *tables), np.arange(len(whole)) + first)


def _on_legendre(functions: Sequence[Any], n: int) -> Real:
    rows = [Polynomial(function.coef).convert(kind=Legendre).coef for function in functions]
    padded = np.array([np.pad(row, (0, n - len(row))) for row in rows])
    return padded / np.sqrt(np.arange(n) + 0.5)
