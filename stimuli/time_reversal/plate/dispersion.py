"""Bending waves: wavelength, phase and group velocity of thin (Kirchhoff) and thick (Mindlin) plates."""

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments.annotations import NotNegativeArray, Positive, PositiveArray
from tactometry.arguments.checked import checked

from ...arrays import FloatArray
from .plate import Plate

MINDLIN_SHEAR_FACTOR: Final = 5 / 6


@checked
def wavenumber_rad_per_m(plate: Plate, frequency_hz: NotNegativeArray) -> FloatArray:
    """Kirchhoff: k = sqrt(omega) (rho_s / D)^(1/4)."""
    return np.sqrt(2 * np.pi * np.asarray(frequency_hz, float) / plate.wave_constant_m2_per_s)


@checked
def wavelength_m(plate: Plate, frequency_hz: PositiveArray) -> FloatArray:
    """Kirchhoff wavelength 2 pi / k.

    >>> from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN
    >>> round(float(wavelength_m(A4_SCREEN, 25e3)) * 1e3, 1)
    20.9
    """
    return 2 * np.pi / wavenumber_rad_per_m(plate, frequency_hz)


@checked
def phase_velocity_m_per_s(plate: Plate, frequency_hz: NotNegativeArray) -> FloatArray:
    """Kirchhoff: omega / k."""
    return np.sqrt(2 * np.pi * np.asarray(frequency_hz, float) * plate.wave_constant_m2_per_s)


@checked
def group_velocity_m_per_s(plate: Plate, frequency_hz: ArrayLike) -> FloatArray:
    """Kirchhoff: d omega / d k = 2 omega / k."""
    return 2 * phase_velocity_m_per_s(plate, frequency_hz)


@checked
def mindlin_group_velocity_m_per_s(
    plate: Plate, frequency_hz: PositiveArray, shear_factor: float = MINDLIN_SHEAR_FACTOR
) -> FloatArray:
    """d omega / d k of the flexural branch, by differentiating its equation in omega^2 and k^2; frequencies above 0.

    >>> from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN
    >>> thick, thin = (v(A4_SCREEN, 60e3) for v in (mindlin_group_velocity_m_per_s, group_velocity_m_per_s))
    >>> round(float(thick / thin), 2)
    0.94
    """
    omega = 2 * np.pi * np.asarray(frequency_hz, float)
    k = mindlin_wavenumber_rad_per_m(plate, frequency_hz, shear_factor)
    rigidity, m = plate.bending_rigidity_n_m, plate.area_density_kg_per_m2
    shear, inertia = shear_stiffness_n_per_m(plate, shear_factor), plate.rotary_inertia_kg
    # the equation of the angular frequency is sheared bent = m A W: its derivatives by k^2 and by W = omega^2
    bent = rigidity * k**2 - inertia * omega**2
    sheared = shear * k**2 - m * omega**2
    by_k2 = shear * bent + rigidity * sheared
    by_omega2 = m * (bent + shear) + inertia * sheared
    return np.asarray(k / omega * by_k2 / by_omega2)


@checked
def mindlin_angular_frequency_rad_per_s(
    plate: Plate, wavenumber_rad_per_m: NotNegativeArray, shear_factor: Positive = MINDLIN_SHEAR_FACTOR
) -> FloatArray:
    """Flexural branch of Mindlin's plate at a wavenumber.

    With kappa G h = A, rho h = m, rho h^3 / 12 = J, the smaller root W = omega^2 of
    (A k^2 - m W)(D k^2 + A - J W) = A^2 k^2, taken as 2c / (b + sqrt(b^2 - 4ac)): no subtraction of near
    equals.
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
    """Wavenumber of the flexural branch at a frequency: the larger root k^2 of the same quadratic."""
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
