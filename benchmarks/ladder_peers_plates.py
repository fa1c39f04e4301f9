"""Frequencies of plates by finite differences, finite elements and other bases, as rungs of the ladders."""

import math
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scikit_fem_plate import bogner_fox_schmit_hz
from scipy import sparse

from tactometry.experiments.cost.problem import Rung
from tactometry.experiments.ladders import boundary_basis, plate_modes
from tactometry.stimuli.time_reversal.plate.plate import Plate
from tactometry.stimuli.time_reversal.plate.rectangle import Family, LegendreAxis
from tactometry.stimuli.time_reversal.plate.ritz import ellipse, pencil

Real = NDArray[np.float64]
CELLS = (20, 40, 80, 160)
ELEMENTS = (6, 10, 16, 24)
DEGREES = (10, 12, 14, 18, 22, 26)


def simply_supported() -> list[Rung]:
    plate = Plate(plate_modes.SIDE_M, plate_modes.SIDE_M, 1e-3, 70e9, 0.3, 2500.0, "SSSS")
    n_modes = len(plate.frequencies_hz(plate_modes.F_MAX_HZ))
    return [
        Rung(f"{n} x {n} cells", partial(_differences_hz, plate, n, n_modes), contender="finite differences")
        for n in CELLS
    ]


def _differences_hz(plate: Plate, n: int, n_modes: int) -> Real:
    """The square of the five-point Laplacian, which is the plate's stencil of thirteen points with edges S."""
    from scipy.sparse.linalg import eigsh

    h = plate.length_m / n
    line = sparse.diags_array([1.0, -2.0, 1.0], offsets=[-1, 0, 1], shape=(n - 1, n - 1)) / h**2
    laplacian = sparse.kronsum(line, line, format="csc")
    lowest = eigsh(laplacian @ laplacian, n_modes, sigma=0.0, return_eigenvectors=False)
    return np.sort(plate.wave_constant_m2_per_s * np.sqrt(lowest) / (2 * math.pi))


def free() -> list[Rung]:
    plate = Plate(plate_modes.SIDE_M, plate_modes.SIDE_M, 1e-3, 70e9, 0.3, 2500.0, "FFFF")
    n_modes = len(plate.frequencies_hz(plate_modes.F_MAX_HZ))
    return [
        Rung(f"{n} x {n} elements", partial(_elements_hz, plate, n, n_modes), contender="scikit-fem BFS")
        for n in ELEMENTS
    ]


def _elements_hz(plate: Plate, n: int, n_modes: int) -> Real:
    return bogner_fox_schmit_hz(plate, n, n, n_modes)[plate.rectangle.n_rigid :]


def other_bases() -> list[Rung]:
    kinds = {"monomials": _monomials, "Legendre, K v = l M v": _legendre}
    return [
        Rung(f"{p} x {p}", partial(_bare_hz, make, p), contender=name) for name, make in kinds.items() for p in DEGREES
    ]


def _bare_hz(make, degree: int) -> Real:  # type: ignore[no-untyped-def]
    """The same Rayleigh quotient on other functions, solved as it stands."""
    from scipy.linalg import LinAlgError, eigh

    plate = boundary_basis.PLATE
    on_x, on_y = make(plate.length_m, degree, held=True), make(plate.width_m, degree, held=False)
    stiffness, mass = pencil(plate.rectangle, on_x, on_y, *ellipse(on_x, on_y, degree, degree))
    try:
        found = eigh(stiffness, mass, eigvals_only=True)
    except LinAlgError:
        return np.full(4, np.nan)
    unit_hz = 4 * plate.wave_constant_m2_per_s / plate.length_m**2 / (2 * math.pi)
    with np.errstate(invalid="ignore"):
        found_hz = unit_hz * np.sqrt(found)
    return found_hz[~(found_hz > boundary_basis.F_MAX_HZ)]


def _monomials(length_m: float, degree: int, *, held: bool) -> Family:
    return _family(length_m, [np.polynomial.Polynomial.basis(k) for k in range(degree + 1 - 2 * held)], held)


def _legendre(length_m: float, degree: int, *, held: bool) -> Family:
    from numpy.polynomial import Legendre, Polynomial

    made = [Legendre.basis(k).convert(kind=Polynomial) * math.sqrt(k + 0.5) for k in range(degree + 1 - 2 * held)]
    return _family(length_m, made, held)


def _family(length_m: float, functions, held: bool) -> Family:  # type: ignore[no-untyped-def]
    """Polynomials of s, times 1 - s^2 where both ends are held, as coefficients on orthonormal Legendre polynomials."""
    edge = np.polynomial.Polynomial([1, 0, -1]) if held else np.polynomial.Polynomial([1])
    whole = [edge * function for function in functions]
    n = max(function.degree() for function in whole) + 1
    tables = [_on_legendre([each.deriv(k) for each in whole], n) for k in range(3)]
    return Family(LegendreAxis(length_m, *tables), np.arange(len(whole)) + 2 * held)


def _on_legendre(functions, n: int) -> Real:  # type: ignore[no-untyped-def]
    rows = [np.polynomial.polynomial.Polynomial(f.coef).convert(kind=np.polynomial.Legendre).coef for f in functions]
    padded = np.array([np.pad(row, (0, n - len(row))) for row in rows])
    return padded / np.sqrt(np.arange(n) + 0.5)
