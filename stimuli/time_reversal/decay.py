"""The attenuation constant from impulse responses, by Schroeder's backward integration."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tactometry.errors import InvalidParameter
from tactometry.stimuli.time_reversal.responses import Responses

FloatArray = NDArray[np.float64]

FIT_FROM_DB: Final = -1.0
FIT_TO_DB: Final = -20.0
CONFIDENCE: Final = 0.95


@dataclass(frozen=True)
class Estimate:
    """A value with the ends of its 95 % interval."""

    value: float
    low: float
    high: float


def schroeder_db(response: FloatArray) -> FloatArray:
    """Energy still to come at each sample, in dB of the whole; minus infinity after the last."""
    to_come = np.cumsum(np.square(response)[..., ::-1], axis=-1)[..., ::-1]
    with np.errstate(divide="ignore"):
        return np.asarray(10 * np.log10(to_come / to_come[..., :1]))


def tau_s(response: FloatArray, rate_hz: float, from_db: float = FIT_FROM_DB, to_db: float = FIT_TO_DB) -> float:
    """Time constant of the amplitude: the slope of ln(energy to come) is -2 / tau.

    Parameters
    ----------
    response : (n_samples,) array
    from_db, to_db : float
        The part of the decay that is fitted, below 0; the end of a short response bends the curve down.

    Raises
    ------
    InvalidParameter
        If the response is silent, or does not fall to `to_db`.

    Examples
    --------
    >>> t = np.arange(10000) / 1e5
    >>> round(tau_s(np.exp(-t / 4e-3) * np.sin(1e4 * t), 1e5) * 1e3, 1)
    4.0
    """
    if not np.any(response):
        raise InvalidParameter("response: found zero everywhere, expected an impulse response")
    level = schroeder_db(response)
    fitted = np.flatnonzero((level <= from_db) & (level >= to_db))
    if len(fitted) < 3 or level[-1] > to_db:
        raise InvalidParameter(
            f"response: found a decay to {level[-1]:.1f} dB, expected at least {to_db} dB; learn longer responses"
        )
    slope_db_per_s = np.polynomial.polynomial.polyfit(fitted / rate_hz, level[fitted], 1)[1]
    return float(-20 / np.log(10) / slope_db_per_s)


def tau_estimate(responses: Responses) -> Estimate:
    """tau over all pairs of point and channel: the mean and its t interval over channels.

    Channels share the plate, so that the interval describes this screen and these places.
    """
    flat = responses.samples.reshape(-1, responses.n_samples)
    return mean_estimate(np.array([tau_s(h, responses.rate_hz) for h in flat]))


def mean_estimate(values: FloatArray, confidence: float = CONFIDENCE) -> Estimate:
    """The mean with its interval from Student's t; infinite with fewer than two values."""
    from scipy.stats import t

    mean = float(np.mean(values))
    if len(values) < 2:
        return Estimate(mean, -np.inf, np.inf)
    half = float(t.ppf((1 + confidence) / 2, len(values) - 1) * np.std(values, ddof=1) / np.sqrt(len(values)))
    return Estimate(mean, mean - half, mean + half)
