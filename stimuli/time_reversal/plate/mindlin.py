"""Frequencies of a thick plate from the modes of the thin one, for any edges.

Each Kirchhoff mode w with omega_K gives three numbers: k_r^2 = <|grad w|^2> / <w^2> for rotary inertia,
k_s^2 = <|grad lap w|^2> / (k_K^4 <w^2>) for the shear force D grad lap w, and the share e of its energy that the
twist of free edges gives back: D (1 - nu) w_ns^2 over a strip of h / (12 kappa)^(1/2) along each (the edge layer of
Mindlin's plate, which makes a strip of width b less stiff in torsion by 2 h / (12 kappa)^(1/2) / b). They replace k in
Mindlin's dispersion,
    m J W^2 - W (m (A + D k_s^2) + A J k_r^2) + A D k_K^4 (1 - e) = 0,  W = omega^2, A = kappa G h, J = m h^2 / 12,
which is exact for simply supported edges (k_r = k_s = k_K, e = 0) and right to first order for others. Derived for
this package; `tests/stimuli/time_reversal/test_mindlin.py` states its error against a solution in three fields.
"""

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from ...arrays import FloatArray
from ..rectangle.axis import LegendreAxis, orthonormal_legendre
from .dispersion import shear_stiffness_n_per_m
from .plate import Plate

if TYPE_CHECKING:
    from ..rectangle.ritz import ParityBlock


BATCH: Final = 64
"""Modes whose tables of coefficients are held at a time."""


def frequencies_rad_per_s(plate: Plate, block: "ParityBlock", shear_factor: float) -> FloatArray:
    """(n_modes,): the frequencies of a block's modes with shear and rotary inertia; rigid modes stay at 0."""
    starts = range(0, len(block.vectors), BATCH)
    batches = (slice(start, start + BATCH) for start in starts)
    thick = [_thick(plate, block.wavenumber2_per_m2[at], _Shapes(plate, block, at), shear_factor) for at in batches]
    return np.concatenate([np.empty(0), *thick])


class _Shapes:
    """Mean squares over the plate of derivatives of some modes of a block, whose own mean square is 1."""

    def __init__(self, plate: Plate, block: "ParityBlock", chosen: slice) -> None:
        vectors = block.vectors[chosen]
        self.plate, self.x, self.y = plate, block.on_x.axis, block.on_y.axis
        self.table = np.zeros((len(vectors), block.on_x.n, block.on_y.n))
        self.table[:, block.i, block.j] = vectors

    def gradient2(self) -> FloatArray:
        return _mean_square(self._of(1, 0)) + _mean_square(self._of(0, 1))

    def shear2(self) -> FloatArray:
        along_x = self._of(3, 0) + self._of(1, 2)
        along_y = self._of(0, 3) + self._of(2, 1)
        return _mean_square(along_x) + _mean_square(along_y)

    def edge_twist2_m(self) -> FloatArray:
        """Integral of w_xy^2 along the free edges over the area, per unit mean square."""
        twist, (a, b) = self._of(1, 1), (self.plate.length_m, self.plate.width_m)
        ends_x, ends_y = (_ends(twist.shape[axis]) for axis in (1, 2))
        on_x = np.square(np.einsum("pe,npq->neq", ends_x, twist)).sum(axis=2) / 2
        on_y = np.square(np.einsum("qe,npq->nep", ends_y, twist)).sum(axis=2) / 2
        free = np.array([edge == "F" for edge in self.plate.boundary], float)
        return np.asarray((on_x @ free[::2]) / a + (on_y @ free[1::2]) / b)

    def _of(self, n_x: int, n_y: int) -> FloatArray:
        """(n_modes, p, q): Legendre coefficients of a derivative."""
        return np.asarray(_derivative(self.x, n_x).T @ self.table @ _derivative(self.y, n_y))


def _thick(plate: Plate, wavenumber2_per_m2: FloatArray, shapes: _Shapes, shear_factor: float) -> FloatArray:
    rigidity, m = plate.bending_rigidity_n_m, plate.area_density_kg_per_m2
    shear, inertia = shear_stiffness_n_per_m(plate, shear_factor), plate.rotary_inertia_kg
    k4 = wavenumber2_per_m2**2
    bent = k4 > 0
    safe = np.where(bent, k4, 1.0)  # a rigid motion bends nothing and is set to 0 below
    layer_m = plate.thickness_m / math.sqrt(12 * shear_factor)
    given_back = 2 * (1 - plate.poisson_ratio) * layer_m * shapes.edge_twist2_m() / safe
    b = m * (shear + rigidity * shapes.shear2() / safe) + shear * inertia * shapes.gradient2()
    c = shear * rigidity * safe / (1 + given_back)
    # the smaller root, as in `dispersion`: no subtraction of near equals
    omega = np.sqrt(2 * c / (b + np.sqrt(b**2 - 4 * m * inertia * c)))
    return np.where(bent, omega, 0.0)


def _derivative(axis: LegendreAxis, n: int) -> FloatArray:
    """(n_functions, degree + 1): coefficients of a derivative with respect to metres."""
    parts = (axis.function, axis.slope, axis.curvature_in_s)
    in_s = parts[n] if n < 3 else parts[2] @ _slope_of_legendre(axis.function.shape[1] - 1)
    return np.asarray((2 / axis.length_m) ** n * in_s)


def _slope_of_legendre(degree: int) -> FloatArray:
    """P_k' on P_j, all orthonormal: 2 ((k + 1/2) (j + 1/2))^(1/2) for j = k - 1, k - 3, ..."""
    root = np.sqrt(np.arange(degree + 1) + 0.5)
    k, j = np.indices((degree + 1, degree + 1))
    return np.where((j < k) & ((k - j) % 2 == 1), 2 * np.outer(root, root), 0.0)


def _mean_square(coefficients: FloatArray) -> FloatArray:
    return np.asarray(np.square(coefficients).sum(axis=(1, 2)) / 4)


def _ends(n: int) -> FloatArray:
    """(n, 2): the orthonormal polynomials at both ends."""
    return orthonormal_legendre(np.array([-1.0, 1.0]), n - 1)
