"""Inverse-filter focusing, what others publish instead of time reversal.

For every frequency the drive of least energy that makes the wanted signal at each point and silence at the others: v =
H^H (H H^H + beta I)^-1 d, with Tikhonov's beta relative to the largest mean power of the responses.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments.annotations import Positive
from tactometry.arguments.checked import checked
from tactometry.arguments.require import expect, finite_array, some, within
from tactometry.errors import InvalidParameter

from ...arrays import FloatArray
from ..filters import Band
from ..plate.dispersion import wavenumber_rad_per_m
from ..plate.plate import Plate
from ..responses.responses import Point, Responses, samples_in


@checked
def inverse_filter_waveform(
    points: Responses,
    wanted: Sequence[float],
    band: Band,
    *,
    reversal_s: float,
    regularisation: Positive = 1e-2,
) -> FloatArray:
    """Waveforms that focus at the last sample, as `focusing.reversed_waveform`.

    Raises `InvalidParameter` if the band passes the Nyquist frequency, `wanted` does not fit or is not finite, all
    responses are zero, or `regularisation` is not above 0.

    Parameters
    ----------
    points : Responses
        The foci and the points to keep quiet.
    wanted : sequence of float
        Amplitude at each point, 0 for a quiet one.
    band : Band
        Spectrum of the pulse that is wanted.
    regularisation : float
        beta, above 0; large values approach time reversal, which is H^H d.

    Returns
    -------
    (n_channels, n_samples) array, scaled to no particular voltage.
    """
    within("Band", 0.0, points.rate_hz / 2, **{"f_max_hz (the Nyquist frequency is the limit)": band.f_max_hz})
    target = np.asarray(wanted, float)
    finite_array("inverse_filter_waveform.wanted", target)
    if target.shape != (points.n_points,) or not target.any():
        raise InvalidParameter(f"wanted: found {wanted}, expected {points.n_points} numbers, not all zero")
    expect(points.samples.any(), "points", "responses that are zero everywhere", "a point that can be moved")
    n = samples_in("reversal_s", reversal_s, points.rate_hz)
    n_fft = 2 * max(n, points.n_samples)
    frequency_hz = np.asarray(np.fft.rfftfreq(n_fft, 1 / points.rate_hz), float)
    transfer = np.moveaxis(np.fft.rfft(points.samples, n_fft), -1, 0)
    # delayed, so that the focus comes at the last of n samples
    pulse = band.at(frequency_hz) * np.exp(-2j * np.pi * frequency_hz * (n - 1) / points.rate_hz)

    # H^H (H H^H + beta I)^-1 (n_frequencies, n_channels, n_points)
    adjoint = np.conj(np.swapaxes(transfer, 1, 2))
    power = transfer @ adjoint
    largest = float(np.abs(np.einsum("fpp->fp", power)).mean(axis=1).max())
    system = power + regularisation * largest * np.eye(power.shape[1])
    inverse = np.conj(np.swapaxes(np.linalg.solve(system, transfer), 1, 2))

    spectrum = inverse @ target * pulse[:, None]
    return np.asarray(np.fft.irfft(spectrum, n_fft, axis=0)[:n].T)


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
