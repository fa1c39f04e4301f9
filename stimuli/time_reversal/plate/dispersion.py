"""Bending waves of thin (Kirchhoff) and thick (Mindlin) plates."""

import math
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments.checked import NotNegativeArray, Positive, PositiveArray, checked

from ...arrays import FloatArray
from .plate import Plate
from .rectangle import LegendreAxis, orthonormal_legendre

if TYPE_CHECKING:
    from .ritz import ParityBlock

MINDLIN_SHEAR_FACTOR: Final = 5 / 6


@checked
def wavenumber_rad_per_m(plate: Plate, frequency_hz: NotNegativeArray) -> FloatArray:
    """Return the Kirchhoff wavenumber k = sqrt(omega) (rho_s / D)^(1/4)."""
    return np.sqrt(2 * np.pi * np.asarray(frequency_hz, float) / plate.wave_constant_m2_per_s)


@checked
def wavelength_m(plate: Plate, frequency_hz: PositiveArray) -> FloatArray:
    """Return the Kirchhoff wavelength 2 pi / k.

    >>> from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN
    >>> round(float(wavelength_m(A4_SCREEN, 25e3)) * 1e3, 1)
    20.9
    """
    return 2 * np.pi / wavenumber_rad_per_m(plate, frequency_hz)


@checked
def phase_velocity_m_per_s(plate: Plate, frequency_hz: NotNegativeArray) -> FloatArray:
    """Return the Kirchhoff phase velocity omega / k."""
    return np.sqrt(2 * np.pi * np.asarray(frequency_hz, float) * plate.wave_constant_m2_per_s)


@checked
def group_velocity_m_per_s(plate: Plate, frequency_hz: ArrayLike) -> FloatArray:
    """Return the Kirchhoff group velocity d omega / d k = 2 omega / k."""
    return 2 * phase_velocity_m_per_s(plate, frequency_hz)


@checked
def mindlin_angular_frequency_rad_per_s(
    plate: Plate, wavenumber_rad_per_m: NotNegativeArray, shear_factor: Positive = MINDLIN_SHEAR_FACTOR
) -> FloatArray:
    """Return the flexural branch of Mindlin's plate at a wavenumber.

    With kappa G h = A, rho h = m, rho h^3 / 12 = J, the smaller root W = omega^2 of (A k^2 - m W)(D k^2 + A - J W) =
    A^2 k^2, computed as 2c / (b + sqrt(b^2 - 4ac)) to avoid cancellation.
    """
    k2 = np.square(np.asarray(wavenumber_rad_per_m, float))
    rigidity, m = plate.bending_rigidity_n_m, plate.area_density_kg_per_m2
    shear, inertia = shear_stiffness_n_per_m(plate, shear_factor), plate.rotary_inertia_kg
    b = m * (rigidity * k2 + shear) + inertia * shear * k2
    c = shear * rigidity * k2**2
    return np.asarray(np.sqrt(2 * c / (b + np.sqrt(b**2 - 4 * m * inertia * c))))


@checked
def mindlin_wavenumber_rad_per_m(
    plate: Plate, frequency_hz: NotNegativeArray, shear_factor: Positive = MINDLIN_SHEAR_FACTOR
) -> FloatArray:
    """Return the wavenumber of the flexural branch at a frequency."""
    w2 = np.square(2 * np.pi * np.asarray(frequency_hz, float))
    rigidity, m = plate.bending_rigidity_n_m, plate.area_density_kg_per_m2
    shear, inertia = shear_stiffness_n_per_m(plate, shear_factor), plate.rotary_inertia_kg
    a = shear * rigidity
    b = w2 * (m * rigidity + inertia * shear)
    c = m * w2 * (inertia * w2 - shear)
    return np.asarray(np.sqrt((b + np.sqrt(b**2 - 4 * a * c)) / (2 * a)))


@checked
def shear_stiffness_n_per_m(plate: Plate, shear_factor: float) -> float:
    shear_modulus_pa = plate.youngs_modulus_pa / (2 * (1 + plate.poisson_ratio))
    return shear_factor * shear_modulus_pa * plate.thickness_m


BATCH: Final = 64
"""Number of modes per chunk of coefficient tables."""


def frequencies_rad_per_s(plate: Plate, block: "ParityBlock", shear_factor: float) -> FloatArray:
    """Return a block's frequencies with shear and rotary inertia."""
    starts = range(0, len(block.vectors), BATCH)
    batches = (slice(start, start + BATCH) for start in starts)
    thick = [_thick(plate, block.wavenumber2_per_m2[at], _Shapes(plate, block, at), shear_factor) for at in batches]
    return np.concatenate([np.empty(0), *thick])


class _Shapes:
    """Mean squares over the plate of the derivatives of modes with mean square 1."""

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
        """Return the integral of w_xy^2 along free edges, divided by the area."""
        twist, (a, b) = self._of(1, 1), (self.plate.length_m, self.plate.width_m)
        ends_x, ends_y = (orthonormal_legendre(np.array([-1.0, 1.0]), twist.shape[axis] - 1) for axis in (1, 2))
        on_x = np.square(np.einsum("pe,npq->neq", ends_x, twist)).sum(axis=2) / 2
        on_y = np.square(np.einsum("qe,npq->nep", ends_y, twist)).sum(axis=2) / 2
        free = np.array([edge == "F" for edge in self.plate.boundary], float)
        return np.asarray((on_x @ free[::2]) / a + (on_y @ free[1::2]) / b)

    def _of(self, n_x: int, n_y: int) -> FloatArray:
        """Return Legendre coefficients of a derivative, (n_modes, p, q)."""
        return np.asarray(_derivative(self.x, n_x).T @ self.table @ _derivative(self.y, n_y))


def _thick(plate: Plate, wavenumber2_per_m2: FloatArray, shapes: _Shapes, shear_factor: float) -> FloatArray:
    rigidity, m = plate.bending_rigidity_n_m, plate.area_density_kg_per_m2
    shear, inertia = shear_stiffness_n_per_m(plate, shear_factor), plate.rotary_inertia_kg
    k4 = wavenumber2_per_m2**2
    bent = k4 > 0
    safe = np.where(bent, k4, 1.0)  # a rigid motion has no bending and is set to 0 below
    layer_m = plate.thickness_m / math.sqrt(12 * shear_factor)
    given_back = 2 * (1 - plate.poisson_ratio) * layer_m * shapes.edge_twist2_m() / safe
    b = m * (shear + rigidity * shapes.shear2() / safe) + shear * inertia * shapes.gradient2()
    c = shear * rigidity * safe / (1 + given_back)
    # the smaller root without cancellation, as in `dispersion`
    omega = np.sqrt(2 * c / (b + np.sqrt(b**2 - 4 * m * inertia * c)))
    return np.where(bent, omega, 0.0)


def _derivative(axis: LegendreAxis, n: int) -> FloatArray:
    """Return coefficients (n_functions, degree + 1) of a derivative over metres."""
    parts = (axis.function, axis.slope, axis.curvature_in_s)
    in_s = parts[n] if n < 3 else parts[2] @ _slope_of_legendre(axis.function.shape[1] - 1)
    return np.asarray((2 / axis.length_m) ** n * in_s)


def _slope_of_legendre(degree: int) -> FloatArray:
    """Return P_k' on orthonormal P_j: 2 ((k + 1/2) (j + 1/2))^(1/2) for j = k - 1, k - 3, ..."""
    root = np.sqrt(np.arange(degree + 1) + 0.5)
    k, j = np.indices((degree + 1, degree + 1))
    return np.where((j < k) & ((k - j) % 2 == 1), 2 * np.outer(root, root), 0.0)


def _mean_square(coefficients: FloatArray) -> FloatArray:
    return np.asarray(np.square(coefficients).sum(axis=(1, 2)) / 4)
