"""Counts of answers at a point z of a psychometric function: log-likelihood and exact derivatives along z, lapse and
guess rate.

The chances are sums of positive parts, so they may pass through the linear scale as long as no chance comes near the
smallest float; data sets where one does are done again in log space.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.special import expit, ndtr

from tactometry.psychometric import SHAPES, Shape, log_mixture

from ..arrays import Array

SMALLEST_LINEAR = 1e-140
"""A chance whose square is still a float."""
_LARGEST_LOG_RATIO = 300.0
_ROOT_TWO_PI = float(np.sqrt(2 * np.pi))


class ByPoint(NamedTuple):
    """Log-likelihood and its derivatives along z, lapse (l) and guess rate (g), elementwise."""

    value: Array
    z: Array
    zz: Array
    lapse: Array
    z_lapse: Array
    lapse_lapse: Array
    guess: Array
    z_guess: Array
    guess_guess: Array
    lapse_guess: Array


def weighted(count: Array, log_chance: Array) -> Array:
    """count * log_chance, where no count gives 0 even at log 0."""
    with np.errstate(invalid="ignore"):
        return np.where(count > 0, count * log_chance, 0.0)


def by_point(shape: Shape, z: Array, guess: Array, lapse: Array, answers: tuple[Array, Array]) -> ByPoint:
    """For `answers` (n_yes, n_no) at z (..., n_levels), and rates that broadcast to it.

    >>> at, none = np.zeros((1, 1)), np.zeros(1)
    >>> found = by_point(SHAPES["logistic"], at, none, none, (at + 3, at + 1))
    >>> float(found.z[0, 0]), float(found.zz[0, 0])
    (1.0, -1.0)
    """
    with np.errstate(all="ignore"):
        by, lowest = _linear(shape, z, guess, lapse, answers)
        lost = ~(lowest > SMALLEST_LINEAR).all(axis=-1)  # negated, as a chance may be NaN
        if not lost.any():
            return by
        rates = (np.broadcast_to(rate, z.shape)[lost] for rate in (guess, lapse))
        counts = (np.broadcast_to(n, z.shape)[lost] for n in answers)
        by_logarithms = _logarithmic(shape, z[lost], *rates, *counts)
        for values, values_lost in zip(by, by_logarithms, strict=True):
            values[lost] = values_lost
    return by


def _normal(z: Array) -> tuple[Array, Array, Array]:
    return ndtr(z), ndtr(-z), np.exp(-0.5 * z * z) / _ROOT_TWO_PI


def _logistic(z: Array) -> tuple[Array, Array, Array]:
    cdf, sf = expit(z), expit(-z)
    return cdf, sf, cdf * sf


def _gumbel(z: Array) -> tuple[Array, Array, Array]:
    with np.errstate(over="ignore", invalid="ignore"):
        rate = np.exp(z)
        sf = np.exp(-rate)
        return -np.expm1(-rate), sf, np.where(sf > 0, rate * sf, 0.0)


def _reversed_gumbel(z: Array) -> tuple[Array, Array, Array]:
    cdf, sf, pdf = _gumbel(-z)
    return sf, cdf, pdf


_LINEAR: dict[Shape, Callable[[Array], tuple[Array, Array, Array]]] = {
    SHAPES["normal"]: _normal,
    SHAPES["logistic"]: _logistic,
    SHAPES["gumbel"]: _gumbel,
    SHAPES["weibull"]: _gumbel,
    SHAPES["reversed_gumbel"]: _reversed_gumbel,
}


def linear(shape: Shape, z: Array) -> tuple[Array, Array, Array]:
    """S, 1 - S and the density of S at z, each with its relative precision."""
    return _LINEAR[shape](z)


def _linear(shape: Shape, z: Array, guess: Array, lapse: Array, answers: tuple[Array, Array]) -> tuple[ByPoint, Array]:
    """And the smaller of the two chances."""
    cdf, sf, pdf = linear(shape, z)
    span = 1 - guess - lapse
    yes, no = guess + span * cdf, lapse + span * sf
    n_yes, n_no = answers
    k_yes, k_no = n_yes / yes, n_no / no
    kk_yes, kk_no = k_yes / yes, k_no / no
    first, second = k_yes - k_no, kk_yes + kk_no  # along psi, the second with its sign turned
    steep = span * pdf
    value = n_yes * np.log(yes) + n_no * np.log(no)
    zz = first * bend(steep, shape.score(z)) - second * steep * steep
    # first and second joined by yes + no = 1: what is left does not cancel, however small a chance is
    z_lapse = pdf * (kk_no * (1 - guess) - kk_yes * guess)
    z_guess = pdf * (kk_no * lapse - kk_yes * (1 - lapse))
    by = ByPoint(
        value=value,
        z=first * steep,
        zz=zz,
        lapse=-first * cdf,
        z_lapse=z_lapse,
        lapse_lapse=-second * cdf * cdf,
        guess=first * sf,
        z_guess=z_guess,
        guess_guess=-second * sf * sf,
        lapse_guess=second * cdf * sf,
    )
    return by, np.minimum(yes, no)


def _logarithmic(shape: Shape, z: Array, guess: Array, lapse: Array, n_yes: Array, n_no: Array) -> ByPoint:
    yes, no = (_one_answer(shape, z, guess, lapse, answer) for answer in (1, 0))
    value = weighted(n_yes, yes[0]) + weighted(n_no, no[0])
    derivatives = zip(yes[1:], no[1:], strict=True)
    return ByPoint(value, *(n_yes * of_yes + n_no * of_no for of_yes, of_no in derivatives))


def _one_answer(shape: Shape, z: Array, guess: Array, lapse: Array, answer: int) -> tuple[Array, ...]:
    """log chance of an answer and its derivatives: z, zz, l, zl, ll, g, zg, gg, lg."""
    log_cdf, log_sf = shape.log_cdf(z), shape.log_sf(z)
    log_chance = log_mixture(log_cdf, log_sf, guess, lapse)[1 - answer]
    sign = 1.0 if answer else -1.0  # what raises the chance of yes lowers that of no
    density, up, down = (_ratio(log_part, log_chance) for log_part in (shape.log_pdf(z), log_cdf, log_sf))
    steep = (1 - guess - lapse) * density
    by_z, by_l, by_g = sign * steep, -sign * up, sign * down
    by_zz = sign * bend(steep, shape.score(z)) - steep * steep
    # As in `_linear`: the cross terms keep the asymptote alone, and nothing cancels.
    if answer:
        log_at_guess, log_at_lapse = np.log(guess), np.log1p(-lapse)
    else:
        log_at_guess, log_at_lapse = np.log1p(-guess), np.log(lapse)
    by_zl = -sign * density * _ratio(log_at_guess, log_chance)
    by_zg = -sign * density * _ratio(log_at_lapse, log_chance)
    by_ll, by_gg, by_lg = -up * up, -down * down, up * down
    return log_chance, by_z, by_zz, by_l, by_zl, by_ll, by_g, by_zg, by_gg, by_lg


def bend(steep: Array, score: Array) -> Array:
    """steep * score, 0 where the density has vanished: it does so faster than its logarithm bends."""
    with np.errstate(invalid="ignore"):
        return np.where(steep > 0, steep * score, 0.0)


def _ratio(log_part: Array, log_chance: Array) -> Array:
    """exp(log_part - log_chance), bounded: an asymptote of 0 makes it infinite."""
    with np.errstate(invalid="ignore"):
        # Where both have vanished their difference would be NaN; the part counts nothing.
        difference = np.where(log_part == -np.inf, -np.inf, log_part - log_chance)
    return np.asarray(np.exp(np.minimum(difference, _LARGEST_LOG_RATIO)))
