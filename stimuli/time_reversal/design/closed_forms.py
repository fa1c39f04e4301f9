"""Closed-form theory of a focus, without simulation.

Sources: diffuse wave fields (J0 correlation, Aki 1957) and a statistical theory of reverberating plates with equal mode
weights, exponential decay and many modes; the latter is our derivation, not the thesis's.
`tactometry.stimuli.time_reversal.design.guide.OFF` states how far the simulation deviates from it. Symbols as in the
thesis: Q transducers, T reversal time, tau attenuation constant, B bandwidth, T_c = modal density.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments.checked import NotNegative, Positive, PositiveArray, PositiveWhole, UnboundedArray, checked
from tactometry.arguments.require import at_most, between, not_negative_array, positive_array

from ...arrays import FloatArray
from ..filters import Band
from ..plate.dispersion import wavenumber_rad_per_m
from ..plate.plate import Plate

CHAOTIC_KURTOSIS: Final = 2.0
"""Kurtosis <phi^4> / <phi^2>^2 - 1 of Gaussian mode shapes."""

RECTANGLE_KURTOSIS: Final = 1.25
"""Kurtosis of products of sines."""

SILENT_TAUS: Final = 40.0
"""Number of tau after which the remainder is below rounding."""

MAX_OVERLAPS: Final = 1000

ALPHA: Final = math.sqrt(math.pi / 2)
"""Factor of the resolution law R_s = alpha (D / rho_s)^(1/4) / sqrt(f_mean): half a wavelength."""


@checked
def one_bit_amplitude_ratio(reversal_s: UnboundedArray, tau_s: Positive) -> FloatArray:
    """Return A(T) / A(inf) = 1 - exp(-T / tau) of the one-bit drive.

    >>> round(float(one_bit_amplitude_ratio(2.0, 1.0)), 3)
    0.865
    """
    not_negative_array("one_bit_amplitude_ratio.reversal_s", reversal_s, infinite=True)
    return np.asarray(-np.expm1(-np.asarray(reversal_s, float) / tau_s))


@checked
def analogue_amplitude_ratio(reversal_s: UnboundedArray, tau_s: Positive) -> FloatArray:
    """Return A(T) / A(inf) = 1 - exp(-2 T / tau) of the analogue drive."""
    not_negative_array("analogue_amplitude_ratio.reversal_s", reversal_s, infinite=True)
    return np.asarray(-np.expm1(-2 * np.asarray(reversal_s, float) / tau_s))


@checked
@dataclass(frozen=True)
class Reverberation:
    """Quantities that determine the contrast of a focus.

    Parameters
    ----------
    n_channels : int
        Q, at least 1.
    bandwidth_hz, tau_s, reversal_s, modal_density_s : float
        B, tau, T and T_c, each above 0.
    kurtosis : float
        kappa, at least 0: 2 for chaotic shapes, 5/4 for a simply supported rectangle.
    """

    n_channels: PositiveWhole
    bandwidth_hz: Positive
    tau_s: Positive
    reversal_s: Positive
    modal_density_s: Positive
    kurtosis: NotNegative = CHAOTIC_KURTOSIS

    @property
    def n_modes(self) -> float:
        """Number of modes in the band, N = n_f B."""
        return self.modal_density_s * self.bandwidth_hz

    @property
    def absorption(self) -> float:
        """Absorption term G = (T_c / 2 tau) coth(T / tau)."""
        return self.modal_density_s / (2 * self.tau_s) / math.tanh(self.reversal_s / self.tau_s)


@checked
def contrast_whole(room: Reverberation) -> float:
    """Return amplitude over the plate's rms: sqrt(Q N / (Q + kappa + G)).

    >>> round(contrast_whole(Reverberation(32, 25e3, 3e-3, 6e-3, 17.96e-3, 2.0)), 1)
    19.7
    """
    q, spread = room.n_channels, room.kurtosis + room.absorption
    return math.sqrt(q * room.n_modes / (q + spread))


@checked
def contrast_limit(room: Reverberation) -> float:
    """Return sqrt(N), the limit for any number of transducers and any T."""
    return math.sqrt(room.n_modes)


@checked
def repetition_noise_ratio(repetition_s: UnboundedArray, tau_s: Positive) -> FloatArray:
    """Return a train's residual noise power: 1 / (1 - exp(-2 T_r / tau))."""
    positive_array("repetition_noise_ratio.repetition_s", repetition_s, infinite=True)
    return np.asarray(-1 / np.expm1(-2 * np.asarray(repetition_s, float) / tau_s))


@checked
def repetition_amplitude_ratio(reversal_s: Positive, repetition_s: Positive, tau_s: Positive) -> float:
    """Return A / A_single in a long 1-bit train of overlapping drives.

    At each instant the reversed responses of several foci add up as Gaussian signals of standard deviations exp(-(s + j
    T_r) / tau), 0 <= s + j T_r <= T. The share of each follows from Bussgang's gain of the sum: the mean over s,
    weighted by exp(-s / tau), of (sum_j exp(-2 j T_r / tau))^(-1/2). Our derivation.

    >>> repetition_amplitude_ratio(6e-3, 10e-3, 3e-3)
    1.0
    """
    from scipy.special import logsumexp

    heard_s = min(reversal_s, SILENT_TAUS * tau_s)
    at_most("min(reversal_s, 40 tau_s) / repetition_s", heard_s / repetition_s, MAX_OVERLAPS)
    s = (np.arange(2000) + 0.5) / 2000 * heard_s
    reach = math.ceil(heard_s / repetition_s)
    j = np.arange(-reach, reach + 1)[:, None] * repetition_s
    present = (s + j >= 0) & (s + j <= heard_s)
    share = np.exp(-0.5 * logsumexp(np.where(present, -2 * j / tau_s, -np.inf), axis=0))
    return float(np.average(share, weights=np.exp(-s / tau_s)))


@checked
def focus_profile(plate: Plate, band: Band, radius_m: ArrayLike) -> FloatArray:
    """Return u(r) / u(0) of a flat band in a diffuse field: 2 [k2 J1(k2 r) - k1 J1(k1 r)] / (r (k2^2 - k1^2)).

    It is computed as the weighted mean of the Airy functions 2 J1(x) / x of both band limits, which is regular at r =
    0.
    """
    r = np.asarray(radius_m, float)
    k1, k2 = wavenumber_rad_per_m(plate, [band.f_min_hz, band.f_max_hz])
    return np.asarray((k2**2 * _airy(k2 * r) - k1**2 * _airy(k1 * r)) / (k2**2 - k1**2))


@checked
def resolution_m(plate: Plate, band: Band, level: float = 0.5) -> float:
    """Return the full width of `focus_profile` at a level from 0 to 1.

    >>> from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN
    >>> round(resolution_m(A4_SCREEN, Band(20e3, 60e3)) * 1e3, 1)
    8.1
    """
    from scipy.optimize import brentq

    between("resolution_m", 0, 1, level=level)
    k_mean = math.sqrt(2 * math.pi * band.mean_hz / plate.wave_constant_m2_per_s)
    return 2 * float(brentq(lambda r: float(focus_profile(plate, band, r)) - level, 0.0, 3.0 / k_mean, xtol=1e-15))


@checked
def half_wavelength_m(plate: Plate, f_mean_hz: PositiveArray, alpha: Positive = ALPHA) -> FloatArray:
    """Return R_s = alpha (D / rho_s)^(1/4) / sqrt(f_mean).

    It is 0.3 to 3.3 % above `resolution_m`.
    """
    return np.asarray(alpha * math.sqrt(plate.wave_constant_m2_per_s) / np.sqrt(np.asarray(f_mean_hz, float)))


def _airy(x: FloatArray) -> FloatArray:
    """Return 2 J1(x) / x, 1 at 0."""
    from scipy.special import j1

    safe = np.where(np.abs(x) < 1e-4, 1.0, x)
    return np.where(np.abs(x) < 1e-4, 1 - np.square(x) / 8, 2 * j1(safe) / safe)


@checked
def patch_response(plate: Plate, side_m: Positive, band: Band) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return frequencies and a patch's W^2 and W^4 averaged over angles.

    A patch with a moment along its outline moves a mode by the mean of its curvature over the patch: a wave along the
    angle theta by W = sinc(k s cos(theta) / 2) sinc(k s sin(theta) / 2), s the side. Our derivation. A patch as long as
    the wave passes some directions and blocks others, the same for all patches. The square of the mean of W^2 instead
    of the mean of W^4 would count the blocked modes too.
    """
    f = np.linspace(max(band.f_min_hz, 1.0), band.f_max_hz, 200)
    half = wavenumber_rad_per_m(plate, f) * side_m / 2
    angle = (np.arange(64) + 0.5) * math.pi / 128
    along, across = np.outer(half, np.cos(angle)), np.outer(half, np.sin(angle))
    squared = (np.sinc(along / math.pi) * np.sinc(across / math.pi)) ** 2
    return f, np.mean(squared, axis=1), np.mean(squared**2, axis=1)


@checked
def passed_hz(plate: Plate, side_m: float, band: Band) -> float:
    """Return the bandwidth that the patch passes, the integral of W^2.

    >>> from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN
    >>> round(passed_hz(A4_SCREEN, 1e-6, Band(20e3, 60e3)))
    40000
    """
    f, squared, _ = patch_response(plate, side_m, band)
    return float(np.trapezoid(squared, f))


@checked
def effective_hz(plate: Plate, side_m: float, band: Band) -> float:
    """Bandwidth of equally many equal modes, (int W^2)^2 / int W^4."""
    f, squared, fourth = patch_response(plate, side_m, band)
    return float(np.trapezoid(squared, f) ** 2 / np.trapezoid(fourth, f))


@checked
def weighted_width_m(plate: Plate, side_m: float, band: Band) -> float:
    """Return the full width of the mean of J0(k r), weighted by W^2."""
    from scipy.optimize import brentq
    from scipy.special import j0

    f, squared, _ = patch_response(plate, side_m, band)
    k = wavenumber_rad_per_m(plate, f)
    k_mean = float(np.average(k, weights=squared))
    return 2 * float(brentq(lambda r: float(np.average(j0(k * r), weights=squared)) - 0.5, 0.0, 3 / k_mean, xtol=1e-15))
