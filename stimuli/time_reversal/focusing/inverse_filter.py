"""Inverse-filter focusing, what others publish instead of time reversal.

For every frequency the drive of least energy that makes the wanted signal at each point and silence at the others: v =
H^H (H H^H + beta I)^-1 d, with Tikhonov's beta relative to the largest mean power of the responses.
"""

from collections.abc import Sequence

import numpy as np

from tactometry.arguments.annotations import Positive
from tactometry.arguments.checked import checked
from tactometry.arguments.require import expect, finite_array, within
from tactometry.errors import InvalidParameter

from ...arrays import FloatArray
from ..filters import Band
from ..responses.responses import Responses, samples_in


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
