"""Learning of impulse responses by regularised deconvolution.

With p the excitation, r the recording and P, R their spectra, h = IFFT(R P* / (abs(P)^2 + epsilon)): Tikhonov's
regularisation, which avoids amplifying noise where the excitation is weak. Zero-padding makes the convolution linear.
With a sweep (Farina, Audio Engineering Society Convention 108, 2000, preprint 5093), distortion products precede the
response. A maximum-length sequence is white and has the lowest peak for its energy.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from tactometry.arguments.checked import Positive, Vector, checked
from tactometry.arguments.require import expect, within
from tactometry.errors import InvalidFile, InvalidParameter
from tactometry.files.durable import read_file
from tactometry.files.json_file import json_value
from tactometry.files.samples import Npz

from ...arrays import FloatArray, fast_length
from ..plate.oscillators import QUANTITIES
from .responses import Responses, samples_in

REGULARISATION: Final = 1e-6
"""Regularisation as a part of the mean power of the excitation's spectrum in its band (unverified default)."""
FADE_PART: Final = 0.05
"""Part of a sweep over which it rises and falls (unverified default)."""


@checked
@dataclass(frozen=True, eq=False)
class Excitation:
    """A signal for one channel, from -1 to 1, and its frequency band.

    >>> sweep(20e3, 60e3, rate_hz=250e3, duration_s=0.01).samples.shape, sequence(10, rate_hz=250e3).samples.shape
    ((2500,), (1023,))
    """

    samples: FloatArray
    rate_hz: float
    f_min_hz: float
    f_max_hz: float
    name: str


@checked
def sweep(f_min_hz: Positive, f_max_hz: float, *, rate_hz: float, duration_s: float) -> Excitation:
    """Return an exponential sweep with raised-cosine ends.

    Raises `InvalidParameter` if the band is not ascending, starts at 0 or exceeds the Nyquist frequency, or the sweep
    is too short.
    """
    within("sweep", np.nextafter(f_min_hz, np.inf), rate_hz / 2, f_max_hz=f_max_hz)  # above `f_min_hz`, not equal to it
    n = samples_in("sweep.duration_s", duration_s, rate_hz)
    expect(n >= 2, "sweep.duration_s", duration_s, "at least two samples")
    time_s = np.arange(n) / rate_hz
    growth_s = n / rate_hz / np.log(f_max_hz / f_min_hz)  # time in which the frequency grows by a factor of e
    phase_rad = 2 * np.pi * f_min_hz * growth_s * np.expm1(time_s / growth_s)
    from_nearer_end = np.minimum(np.arange(n), np.arange(n)[::-1])
    edge = np.clip(from_nearer_end / max(FADE_PART * n, 1.0), 0.0, 1.0)
    samples = np.sin(phase_rad) * np.sin(np.pi / 2 * edge) ** 2
    return Excitation(samples, rate_hz, f_min_hz, f_max_hz, "sweep")


@checked
def sequence(order: int, *, rate_hz: Positive) -> Excitation:
    """Return a maximum-length sequence of 2^order - 1 values of +1 and -1.

    It fills the band up to the Nyquist frequency. Raises `InvalidParameter` if the order is not from 2 to 24.
    """
    from scipy.signal import max_len_seq

    within("sequence", 2, 24, order=order)
    return Excitation(
        1.0 - 2.0 * max_len_seq(order)[0].astype(np.float64), rate_hz, 0.0, rate_hz / 2, "maximum-length sequence"
    )


@checked
def deconvolve(
    played: Vector, recorded: FloatArray, n_samples: int, *, regularisation: float = REGULARISATION
) -> FloatArray:
    """Return the response that turns `played` into `recorded`.

    Raises `InvalidParameter` if a value is out of range or the excitation is zero.

    Parameters
    ----------
    played : (n_played,) array
        The excitation, or its recording on a reference channel, which removes the latency.
    recorded : (..., n_recorded) array
        Recording from the same instant on. Later samples count as zero, so record the decay too.
    n_samples : int
        Length of the response, from 1 to `n_recorded`.
    regularisation : float
        Epsilon as a part of the mean power of the played spectrum, at least 0. The response is scaled by P^2 / (P^2 +
        epsilon): its relative error is about this value at mean power, and the response is small where the excitation
        is weak.

    Returns
    -------
    (..., n_samples) array

    >>> h = np.array([0.0, 2.0, -1.0])
    >>> pulse = sequence(6, rate_hz=1e3).samples
    >>> deconvolve(pulse, np.convolve(pulse, h), 3, regularisation=0.0).round(9).tolist()
    [0.0, 2.0, -1.0]
    """
    within("deconvolve", 1, recorded.shape[-1], n_samples=n_samples)
    within("deconvolve", 0.0, 1e6, regularisation=regularisation)
    n_fft = fast_length(played.shape[-1] + recorded.shape[-1])
    spectrum = np.fft.rfft(played, n_fft)
    power = np.square(np.abs(spectrum))
    expect(power.any(), "played", "zeros alone", "an excitation")
    inverse = np.conj(spectrum) / (power + regularisation * power.mean())
    return np.asarray(np.fft.irfft(np.fft.rfft(recorded, n_fft) * inverse, n_fft)[..., :n_samples])


@checked
def delay_s(played: Vector, recorded: Vector, rate_hz: Positive) -> float:
    """Return the delay (s) of `recorded` from the correlation peak.

    A parabola interpolates fractions of a sample.

    >>> pulse = sequence(8, rate_hz=1e3).samples
    >>> delay_s(pulse, np.concatenate([np.zeros(7), pulse]), 1e3)
    0.007
    """
    from scipy.signal import correlate, correlation_lags

    matched = np.abs(correlate(recorded, played, method="fft"))
    lags = correlation_lags(len(recorded), len(played))
    peak = int(np.argmax(np.where(lags >= 0, matched, -1.0)))  # only delays of at least 0 are possible
    before, at, after = (matched[min(max(peak + k, 0), len(matched) - 1)] for k in (-1, 0, 1))
    bend = before - 2 * at + after
    shift = 0.5 * (before - after) / bend if bend < 0 else 0.0
    return float(round((lags[peak] + shift) / rate_hz, 12))


@checked
def learn(
    played: FloatArray,
    recorded: FloatArray,
    rate_hz: float,
    *,
    duration_s: float,
    quantity: str = "displacement",
    regularisation: float = REGULARISATION,
) -> Responses:
    """Learn the responses of one point to every channel.

    Raises `InvalidParameter` if the shapes do not match or a value is out of range.

    Parameters
    ----------
    played : (n_played,) or (n_channels, n_recorded) array
        The common excitation in the unit of the drive (V), or a reference recording for each channel.
    recorded : (n_channels, n_recorded) array
        Motion of the point in the unit of `quantity`, with one channel played at a time.
    rate_hz : float
    duration_s : float
        Length of the returned responses.
    """
    recorded = np.asarray(recorded, float)
    played = np.asarray(played, float)
    if recorded.ndim != 2 or played.ndim not in (1, 2) or (played.ndim == 2 and len(played) != len(recorded)):
        raise InvalidParameter(
            f"learn: found played {played.shape} and recorded {recorded.shape}, expected (n_played,) or one row per "
            "channel, and (n_channels, n_recorded)"
        )
    n = samples_in("learn.duration_s", duration_s, rate_hz)
    rows = np.broadcast_to(played, (len(recorded), played.shape[-1]))
    samples = [deconvolve(p, r, n, regularisation=regularisation) for p, r in zip(rows, recorded, strict=True)]
    return Responses(np.array(samples)[None], rate_hz, quantity)


@checked
def as_displacement(responses: Responses, f_min_hz: Positive, f_max_hz: float) -> Responses:
    """Integrate velocity or acceleration responses to displacement.

    The spectrum is divided by (i omega)^k within a band and set to 0 elsewhere.

    The band's edges rise and fall over a tenth of `f_min_hz`, so that the response stays short.

    Raises `InvalidParameter` if the band is not ascending, starts at 0 or exceeds the Nyquist frequency.

    >>> velocity = Responses(np.eye(1, 64, 9)[None], 1e3, "velocity")
    >>> as_displacement(velocity, 100.0, 400.0).quantity
    'displacement'
    """
    within("as_displacement", np.nextafter(f_min_hz, np.inf), responses.rate_hz / 2, f_max_hz=f_max_hz)
    n_fft = 2 * responses.n_samples
    frequency_hz = np.fft.rfftfreq(n_fft, 1 / responses.rate_hz)
    above_hz, below_hz = frequency_hz - 0.9 * f_min_hz, f_max_hz + 0.1 * f_min_hz - frequency_hz
    inside_hz = np.clip(np.minimum(above_hz, below_hz), 0, None)
    window = np.sin(np.pi / 2 * np.clip(inside_hz / (0.1 * f_min_hz), 0, 1)) ** 2
    n_integrations = QUANTITIES.index(responses.quantity)
    factor = window / (2j * np.pi * np.where(window > 0, frequency_hz, 1.0)) ** n_integrations
    samples = np.fft.irfft(np.fft.rfft(responses.samples, n_fft) * factor, n_fft)[..., : responses.n_samples]
    return Responses(samples, responses.rate_hz, "displacement")


@checked
def write_learnt(responses: Responses, path: Path, provenance: Mapping[str, str | float | int]) -> None:
    """Write responses as NPZ with their ``provenance`` as JSON."""
    content = json.dumps(dict(provenance))
    np.savez(
        path, samples=responses.samples, rate_hz=responses.rate_hz, quantity=responses.quantity, provenance=content
    )


@checked
def read_provenance(path: Path) -> dict[str, str | float | int]:
    """Return the provenance of learnt responses, or {} if none is stored.

    Raises `InvalidFile` if the file is not an NPZ file of responses.
    """
    content = read_file(path, "learnt responses")
    try:
        file = Npz(content)
        return dict(json_value(file.words("provenance"))) if "provenance" in file else {}
    except (ValueError, TypeError) as error:
        raise InvalidFile(f"{path}: cannot be read as learnt responses ({error}), expected an NPZ file") from None
