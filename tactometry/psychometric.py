"""Psychometric function: probability of a response against level.

``psi(x) = g + (1 - g - l) S(z)`` with ``z = z50 + (x - threshold) / width * (z95 - z05)``: the threshold is the level
where the unscaled function S is 0.5, the width is the distance between its 0.05 and 0.95 points (Schuett, Harmeling,
Macke and Wichmann 2016, Vision Research 122, 105-123). No probability is computed as one minus another, so that both
tails keep their digits.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from math import isfinite, log
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .arguments.constraints import Positive, Share, constrained
from .arguments.require import expect, lookup
from .errors import InvalidParameter

Array = NDArray[np.float64]
Function = Callable[[Array], Array]
LEFT, RIGHT = 0.05, 0.95


@dataclass(frozen=True)
class Shape:
    """Sigmoid S(z) in standard form, evaluated elementwise.

    `score` is the derivative of `log_pdf`, `at` the inverse of S from log S and log(1 - S).
    """

    log_cdf: Function
    log_sf: Function
    log_pdf: Function
    score: Function
    at: Callable[[Array, Array], Array]
    on_log_levels: bool = False

    @property
    def z50(self) -> float:
        return self._quantile(0.5)

    @property
    def z_width(self) -> float:
        """Distance between the 0.05 and 0.95 points of S."""
        return self._quantile(RIGHT) - self._quantile(LEFT)

    @property
    def rise(self) -> tuple[float, float]:
        """Distances of the 0.05 and 0.95 points from the threshold, in widths."""
        return (self.z50 - self._quantile(LEFT)) / self.z_width, (self._quantile(RIGHT) - self.z50) / self.z_width

    @cache  # noqa: B019 - the few shapes live as long as the program
    def _quantile(self, probability: float) -> float:
        return float(self.at(np.array(log(probability)), np.array(np.log1p(-probability))))


def log1mexp(x: Array) -> Array:
    """Return log(1 - exp(-x)) for x >= 0, exact in both tails (Maechler 2012).

    >>> float(log1mexp(np.array(1e-300)))
    -690.7755278982137
    """
    x = np.asarray(x, dtype=np.float64)
    with np.errstate(divide="ignore"):
        # on each side of exp(-x) = 1/2, use the form without cancellation
        return np.where(x < np.log(2), np.log(-np.expm1(-x)), np.log1p(-np.exp(-x)))


def _gumbel_log_sf(z: Array) -> Array:
    with np.errstate(over="ignore"):
        return -np.exp(z)


def _gumbel_log_cdf(z: Array) -> Array:
    """Return log(1 - exp(-exp z)), computed by its series where exp(z) < 1e-16."""
    # `where` computes both branches: the maximum avoids log 0 in the unused one
    return np.where(z < -37.0, z, log1mexp(-_gumbel_log_sf(np.maximum(z, -40.0))))


def _log_of_minus(log_probability: Array) -> Array:
    with np.errstate(divide="ignore"):
        return np.log(-log_probability)


def _log_ndtr(z: Array) -> Array:
    from scipy.special import log_ndtr  # slow to load

    return np.asarray(log_ndtr(z))


def _log_expit(z: Array) -> Array:
    from scipy.special import log_expit

    return np.asarray(log_expit(z))


def _normal_at(log_cdf: Array, log_sf: Array) -> Array:
    from scipy.special import ndtri_exp

    # use the smaller tail: the logarithm of the larger is near 0 and imprecise
    return np.where(log_cdf < log_sf, ndtri_exp(log_cdf), -ndtri_exp(log_sf))


_GUMBEL = Shape(
    log_cdf=_gumbel_log_cdf,
    log_sf=_gumbel_log_sf,
    log_pdf=lambda z: z + _gumbel_log_sf(z),
    score=lambda z: 1.0 + _gumbel_log_sf(z),
    at=lambda log_cdf, log_sf: _log_of_minus(log_sf),
)

SHAPES: Mapping[str, Shape] = MappingProxyType(
    {
        "normal": Shape(
            log_cdf=_log_ndtr,
            log_sf=lambda z: _log_ndtr(-z),
            log_pdf=lambda z: -0.5 * z * z - 0.5 * np.log(2 * np.pi),
            score=lambda z: -z,
            at=_normal_at,
        ),
        "logistic": Shape(
            log_cdf=_log_expit,
            log_sf=lambda z: _log_expit(-z),
            log_pdf=lambda z: _log_expit(z) + _log_expit(-z),
            score=lambda z: -np.tanh(0.5 * z),
            at=lambda log_cdf, log_sf: log_cdf - log_sf,
        ),
        "gumbel": _GUMBEL,
        "reversed_gumbel": Shape(
            log_cdf=lambda z: _gumbel_log_sf(-z),
            log_sf=lambda z: _gumbel_log_cdf(-z),
            log_pdf=lambda z: _GUMBEL.log_pdf(-z),
            score=lambda z: -_GUMBEL.score(-z),
            at=lambda log_cdf, log_sf: -_log_of_minus(log_cdf),
        ),
        "weibull": replace(_GUMBEL, on_log_levels=True),
    }
)


def shape_named(name: str) -> Shape:
    """Return the shape of this name, or raise `InvalidParameter`."""
    return lookup("shape", name, SHAPES)


@dataclass(frozen=True)
@constrained
class PsychometricFunction:
    """Probability of a correct (or "yes") response as a function of level.

    - `shape`: ``normal``, ``logistic``, ``gumbel``, ``reversed_gumbel``, or ``weibull`` on positive levels: a Gumbel in
      the natural logarithm of the level.
    - `threshold`: Level where the unscaled function is one half, in the unit of the levels. It is above 0 for
      ``weibull``.
    - `width`: Distance between the 0.05 and 0.95 points of the unscaled function, above 0. It is in the unit of the
      levels, for ``weibull`` in natural logarithms of the level.
    - `guess_rate`, `lapse_rate`: Lower asymptote, and distance of the upper asymptote from 1, each in [0, 1], with a
      sum below 1.

    Raises `InvalidParameter` if a parameter is out of range.

    >>> f = PsychometricFunction("normal", threshold=20.0, width=8.0, guess_rate=0.5, lapse_rate=0.02)
    >>> round(float(f.probability(20.0)), 12)
    0.74
    >>> round(float(f.level(0.74)), 12)
    20.0
    """

    shape: str
    threshold: float
    width: Positive
    guess_rate: Share
    lapse_rate: Share

    def __post_init__(self) -> None:
        standard = shape_named(self.shape)
        is_level = isfinite(self.threshold) and (self.threshold > 0 or not standard.on_log_levels)
        above = f" above 0 for the shape {self.shape!r}" if standard.on_log_levels else ""
        expect(is_level, "threshold", self.threshold, f"a finite level{above}")
        rates = f"{self.guess_rate} and {self.lapse_rate}"
        expect(self.guess_rate + self.lapse_rate < 1, "guess_rate, lapse_rate", rates, "a sum below 1")

    def probability(self, level: ArrayLike) -> Any:
        """Return psi(level), in the shape of `level`.

        Raises `InvalidParameter` if a level is not a number, or not above 0 for the shape ``weibull``.
        """
        return np.exp(self.log_probability(level, 1))

    def log_probability(self, level: ArrayLike, response: ArrayLike) -> Any:
        """Return log psi for responses 1 and log(1 - psi) for responses 0.

        Raises `InvalidParameter` if a level is not a number (or not above 0 for ``weibull``), or a response neither 0
        nor 1.
        """
        answer = np.asarray(response)
        if answer.dtype.kind not in "biuf" or not np.isin(answer, (0, 1)).all():
            raise InvalidParameter(f"response: found {response!r}, expected 1 or 0")
        shape, z = SHAPES[self.shape], self._z(level)
        yes, no = log_mixture(shape.log_cdf(z), shape.log_sf(z), self.guess_rate, self.lapse_rate)
        return np.where(answer == 1, yes, no)[()]  # return a scalar for scalars

    def level(self, probability: ArrayLike) -> Any:
        """Return the level at which psi is `probability`, in its shape.

        Raises `InvalidParameter` if a probability is not between the asymptotes.
        """
        p = np.asarray(probability, dtype=np.float64)
        low, high = self.guess_rate, 1 - self.lapse_rate
        among = f"values between the asymptotes, {low} and {high}"
        expect(((p > low) & (p < high)).all(), "probability", repr(probability), among)
        shape, span = SHAPES[self.shape], 1 - self.guess_rate - self.lapse_rate
        z = shape.at(np.log((p - low) / span), np.log((high - p) / span))
        return self._from_z(z)[()]

    def _z(self, level: ArrayLike) -> Array:
        shape, x = SHAPES[self.shape], _levels(level)
        if shape.on_log_levels:
            if not (x > 0).all():
                raise InvalidParameter(f"level: found {level!r}, expected levels above 0 for the shape {self.shape!r}")
            distance = np.log(x) - np.log(self.threshold)
        else:
            distance = x - self.threshold
        return np.asarray(shape.z50 + distance / self.width * shape.z_width)

    def _from_z(self, z: Array) -> Array:
        shape = SHAPES[self.shape]
        distance = (z - shape.z50) / shape.z_width * self.width
        return np.asarray(self.threshold * np.exp(distance) if shape.on_log_levels else self.threshold + distance)


def log_mixture(log_cdf: Array, log_sf: Array, guess_rate: ArrayLike, lapse_rate: ArrayLike) -> tuple[Array, Array]:
    """Return log psi and log(1 - psi) from log S and log(1 - S).

    >>> yes, no = log_mixture(np.array(-1e4), np.array(0.0), 0.0, 0.0)
    >>> float(yes), float(no)
    (-10000.0, 0.0)
    """
    guess, lapse = np.asarray(guess_rate, dtype=np.float64), np.asarray(lapse_rate, dtype=np.float64)
    with np.errstate(divide="ignore"):  # a rate of 0 is log 0 = -inf, which `logaddexp` handles
        log_guess, log_lapse, log_span = np.log(guess), np.log(lapse), np.log1p(-guess - lapse)
    return np.logaddexp(log_guess, log_span + log_cdf), np.logaddexp(log_lapse, log_span + log_sf)


def _levels(level: ArrayLike) -> Array:
    try:
        x = np.asarray(level, dtype=np.float64)
    except (TypeError, ValueError):
        raise InvalidParameter(f"level: found {level!r}, expected numbers") from None
    if np.isnan(x).any():
        raise InvalidParameter(f"level: found {level!r}, expected numbers, not NaN")
    return x
