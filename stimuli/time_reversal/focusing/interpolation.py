"""Foci anywhere from a calibrated set of points, with the error that costs.

In a diffuse field the responses at two points a distance r apart are correlated as J0(k r). The best linear
estimate at a new point is then, frequency by frequency, w = C^-1 c with C and c from J0; it finds the share
c^T C^-1 c of the power. Within a grid finer than half a wavelength that share is near 1; far from every
point it is 0.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments.checked import checked
from tactometry.arguments.require import expect, some, within

from ...arrays import FloatArray
from ..filters import Band
from ..plate.dispersion import wavenumber_rad_per_m
from ..plate.plate import Plate
from ..responses.responses import Point, Responses

NOISE_SHARE: Final = 1e-4
"""Power of measurement noise relative to the responses; keeps C invertible."""


@checked
def interpolate(
    calibrated: Responses, points: Sequence[Point], at: Point, plate: Plate, noise_share: float = NOISE_SHARE
) -> Responses:
    """The responses at a new point from those at calibrated ones.

    Parameters
    ----------
    calibrated : Responses
        One row per point.
    points : sequence of (x_m, y_m)
    at : (x_m, y_m)
    """
    expect(len(points) == calibrated.n_points, "points", len(points), f"{calibrated.n_points}, one per row")
    n_fft = 2 * max(calibrated.n_samples, 1)
    frequency_hz = np.fft.rfftfreq(n_fft, 1 / calibrated.rate_hz)
    weights, _ = estimator(points, at, plate, frequency_hz, noise_share)
    spectrum = np.einsum("fp,pqf->qf", weights, np.fft.rfft(calibrated.samples, n_fft))
    return replace(calibrated, samples=np.fft.irfft(spectrum, n_fft)[None, :, : calibrated.n_samples])


@checked
def estimator(
    points: Sequence[Point], at: Point, plate: Plate, frequency_hz: ArrayLike, noise_share: float = NOISE_SHARE
) -> tuple[FloatArray, FloatArray]:
    """Weights (n_frequencies, n_points), and the share of the power at the new point that they find."""
    from scipy.special import j0

    within("estimator", 1e-12, 1e6, noise_share=noise_share)
    some("estimator.points", points)
    place = np.asarray(points, float).reshape(-1, 2)
    k = wavenumber_rad_per_m(plate, np.atleast_1d(frequency_hz))
    between = place[:, None, :] - place[None, :, :]
    apart = np.hypot(between[..., 0], between[..., 1])  # (n_points, n_points)
    away = np.hypot(*(place - np.asarray(at, float)).T)
    among = j0(k[:, None, None] * apart) + noise_share * np.eye(len(place))
    toward = j0(k[:, None] * away)
    weights = np.linalg.solve(among, toward[:, :, None])[:, :, 0]
    return weights, np.clip(np.einsum("fp,fp->f", weights, toward), 0.0, 1.0)


@checked
def expected_amplitude_ratio(
    points: Sequence[Point], at: Point, plate: Plate, band: Band, noise_share: float = NOISE_SHARE
) -> float:
    """A / A_0 of an analogue focus learnt by interpolation: the mean over the band of the share of power found.

    The 1-bit drive follows the correlation of waveforms, the square root of that share.
    """
    _, share = estimator(points, at, plate, np.linspace(max(band.f_min_hz, 1.0), band.f_max_hz, 200), noise_share)
    return float(share.mean())
