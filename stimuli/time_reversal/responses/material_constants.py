"""Material constants of a plate from what was measured on it (thesis 3.4.2), each with a 95 % interval."""

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments.checked import checked
from tactometry.arguments.require import positive_array
from tactometry.errors import InvalidParameter

from ...arrays import FloatArray
from ..plate.plate import Plate
from .decay import TauEstimate, mean_estimate


@checked
def rigidity_ratio_from_dispersion(frequency_hz: ArrayLike, wavenumber_rad_per_m: ArrayLike) -> TauEstimate:
    """D / rho_s (m^4/s^2) from wavenumbers at frequencies: omega^2 / k^4 of each, averaged in logarithm.

    >>> k = np.array([50.0, 100.0, 200.0])
    >>> round(rigidity_ratio_from_dispersion(1.7 * k**2 / (2 * np.pi), k).value, 9)
    2.89
    """
    f, k = _pairs("frequency_hz", frequency_hz, wavenumber_rad_per_m)
    return _geometric(np.log((2 * np.pi * f) ** 2 / k**4))


@checked
def rigidity_ratio_from_modes(measured_hz: ArrayLike, guess: Plate) -> TauEstimate:
    """D / rho_s from measured modal frequencies, assigned to the modes of a plate that is known but for its glass.

    Each measured frequency, in ascending order, goes to the nearest mode of `guess` on a logarithmic scale, times
    the common factor of those before it; the first goes to the first mode. Frequencies depend on D / rho_s by
    its square root, and through the edges weakly on Poisson's ratio, which is taken from `guess`.

    Parameters
    ----------
    measured_hz : sequence of float
        Ascending, above 0, from the first elastic mode on; later modes may be missing.
    guess : Plate
        Size, edges and Poisson's ratio as measured; modulus and density of the right order.
    """
    measured = np.asarray(measured_hz, float)
    positive_array("rigidity_ratio_from_modes.measured_hz", measured)
    if measured.ndim != 1 or len(measured) == 0 or not (np.diff(measured) >= 0).all():
        raise InvalidParameter(f"measured_hz: found {measured.tolist()}, expected ascending frequencies above 0")
    factor = measured[0] / _elastic(guess, 4.0)[0]
    model = _elastic(guess, 1.2 * measured[-1] / factor)
    if len(model) < len(measured):
        raise InvalidParameter(
            f"measured_hz: found {len(measured)} modes up to {measured[-1]} Hz, the plate has {len(model)} there"
        )
    return _geometric(2 * np.log(guess.wave_constant_m2_per_s * measured / _nearest(measured, model)))


@checked
def alpha_from_resolutions(resolution_m: ArrayLike, f_mean_hz: ArrayLike, plate: Plate) -> TauEstimate:
    """The factor of R_s = alpha (D / rho_s)^(1/4) / sqrt(f_mean) from measured resolutions, averaged in logarithm.

    Theory of a diffuse field gives sqrt(pi / 2) = 1.2533 for the full width at half amplitude.
    """
    width, f = _pairs("resolution_m", resolution_m, f_mean_hz)
    return _geometric(np.log(width * np.sqrt(f) / np.sqrt(plate.wave_constant_m2_per_s)))


@checked
def youngs_modulus_pa(rigidity_ratio: TauEstimate, plate: Plate) -> TauEstimate:
    """Y = 12 (1 - nu^2) rho_s (D / rho_s) / h^3 with the density, thickness and Poisson's ratio of
    `plate`.
    """
    factor = 12 * (1 - plate.poisson_ratio**2) * plate.area_density_kg_per_m2 / plate.thickness_m**3
    ratios = rigidity_ratio.value, rigidity_ratio.low, rigidity_ratio.high
    return TauEstimate(*(factor * ratio for ratio in ratios))


def _elastic(plate: Plate, f_max_hz: float) -> FloatArray:
    """Frequencies above 0, at least one: the range doubles until it holds a mode."""
    frequencies = plate.frequencies_hz(f_max_hz)
    elastic = frequencies[frequencies > 0]
    return elastic if len(elastic) else _elastic(plate, 2 * f_max_hz)


def _nearest(measured: FloatArray, model: FloatArray) -> FloatArray:
    """(n_measured,): the mode that each belongs to, by the mean factor of those before it."""
    # in logarithms a wrong rigidity shifts all modes alike
    heard, modes = np.log(measured), np.log(model)
    paired = modes[:1]
    for i in range(1, len(heard)):
        expected = modes + np.mean(heard[:i] - paired)
        paired = np.append(paired, modes[np.argmin(np.abs(heard[i] - expected))])
    return np.asarray(np.exp(paired))


def _geometric(logarithms: FloatArray) -> TauEstimate:
    inside = mean_estimate(logarithms)
    return TauEstimate(*(float(np.exp(logarithm)) for logarithm in (inside.value, inside.low, inside.high)))


def _pairs(name: str, first: ArrayLike, second: ArrayLike) -> tuple[FloatArray, FloatArray]:
    a, b = np.asarray(first, float), np.asarray(second, float)
    if a.shape != b.shape or a.ndim != 1 or len(a) == 0 or not ((a > 0).all() and (b > 0).all()):
        raise InvalidParameter(f"{name}: found shapes {a.shape} and {b.shape}, expected two lists of numbers above 0")
    return a, b
