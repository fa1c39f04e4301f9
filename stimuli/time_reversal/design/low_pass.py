"""The low-pass of a square patch: how it weights the modes of a band, and what that does to their number and width.

A patch with a moment along its outline moves a mode by the mean of its curvature over the patch: a wave along the angle
theta by W = sinc(k s cos(theta) / 2) sinc(k s sin(theta) / 2), s the side. Derived.
"""

import math

import numpy as np

from tactometry.arguments.checked import checked
from tactometry.arguments.require import positive

from ...arrays import FloatArray
from ..filters import Band
from ..plate.dispersion import wavenumber_rad_per_m
from ..plate.plate import Plate


@checked
def passed(plate: Plate, side_m: float, band: Band) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Frequencies over the band, and W^2 and W^4 there, each averaged over directions.

    A patch as long as the wave passes some directions and not others, and all patches pass the same: the square of the
    mean of W^2 in place of the mean of W^4 would count the modes of those others.
    """
    positive("passed", side_m=side_m)
    f = np.linspace(max(band.f_min_hz, 1.0), band.f_max_hz, 200)
    half = wavenumber_rad_per_m(plate, f) * side_m / 2
    angle = (np.arange(64) + 0.5) * math.pi / 128
    along, across = np.outer(half, np.cos(angle)), np.outer(half, np.sin(angle))
    squared = (np.sinc(along / math.pi) * np.sinc(across / math.pi)) ** 2
    return f, np.mean(squared, axis=1), np.mean(squared**2, axis=1)


@checked
def passed_hz(plate: Plate, side_m: float, band: Band) -> float:
    """The integral of W^2 over the band: the width of the band that the patch lets pass.

    >>> from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN
    >>> round(passed_hz(A4_SCREEN, 1e-6, Band(20e3, 60e3)))
    40000
    """
    f, squared, _ = passed(plate, side_m, band)
    return float(np.trapezoid(squared, f))


@checked
def effective_hz(plate: Plate, side_m: float, band: Band) -> float:
    """Bandwidth of as many equal modes: (integral of W^2)^2 / integral of W^4."""
    f, squared, fourth = passed(plate, side_m, band)
    return float(np.trapezoid(squared, f) ** 2 / np.trapezoid(fourth, f))


@checked
def weighted_width_m(plate: Plate, side_m: float, band: Band) -> float:
    """Full width at -6 dB of the mean of J0(k r) over the band, weighted by W^2."""
    from scipy.optimize import brentq
    from scipy.special import j0

    f, squared, _ = passed(plate, side_m, band)
    k = wavenumber_rad_per_m(plate, f)
    k_mean = float(np.average(k, weights=squared))
    return 2 * float(brentq(lambda r: float(np.average(j0(k * r), weights=squared)) - 0.5, 0.0, 3 / k_mean, xtol=1e-15))
