"""Log-likelihood of psychometric functions with exact derivatives.

A parameter vector is (m, v, l, g): threshold and log width on the scale of `Counts.u`, lapse rate, guess rate. All
functions compute many data sets at once.

The probabilities are sums of positive parts, so the linear scale is accurate. Data sets with a probability near the
smallest float are computed again in log space.

Beta-binomial answers (Schuett et al. 2016): eta in [0, 1) is the overdispersion, nu = 1/eta^2 - 1, and the probability
of a block is drawn from Beta(nu psi, nu (1 - psi)); the variance of k is n psi (1 - psi) (1 + (n - 1) eta^2).
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.special import expit, gammaln, ndtr, polygamma, psi, xlogy

from tactometry.psychometric import SHAPES, Shape, log_mixture

from ..arrays import Array, Expansion
from .counts import Counts

N_PARAMETERS = 4
THRESHOLD, LOG_WIDTH, LAPSE, GUESS = range(N_PARAMETERS)
BINOMIAL_BELOW = 1e-4
"""Overdispersion below which the beta-binomial equals the binomial up to rounding."""
SMALLEST_CHANCE = 1e-100
SMALLEST_LINEAR = 1e-140
"""Smallest probability whose square does not underflow."""
LARGEST_LOG_RATIO = 300.0
ROOT_TWO_PI = float(np.sqrt(2 * np.pi))


def weighted(count: Array, log_chance: Array) -> Array:
    """Return count * log_chance, or 0 if the count is 0 (even for log 0)."""
    with np.errstate(invalid="ignore"):
        return np.where(count > 0, count * log_chance, 0.0)


def _normal(z: Array) -> tuple[Array, Array, Array]:
    return ndtr(z), ndtr(-z), np.exp(-0.5 * z * z) / ROOT_TWO_PI


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
    """Return S, 1 - S and the density of S at z, each precise."""
    return _LINEAR[shape](z)


class Slopes(NamedTuple):
    """Derivatives of a log-likelihood in z, lapse rate and guess rate."""

    z: Array
    zz: Array
    lapse: Array
    z_lapse: Array
    lapse_lapse: Array
    guess: Array
    z_guess: Array
    guess_guess: Array
    lapse_guess: Array


def _slopes(first: Array, second: Array, parts: tuple[Array, Array, Array], span: Array, score: Array) -> Slopes:
    """Convert derivatives in psi = guess + span * S by the chain rule.

    `first` is the slope in psi, `second` the negative curvature. `parts` are S, 1 - S and the density of S, `score`
    is the slope of the log density.
    """
    cdf, sf, pdf = parts
    steep = span * pdf
    return Slopes(
        z=first * steep,
        zz=first * np.where(steep > 0, steep * score, 0.0) - second * steep * steep,
        lapse=-first * cdf,
        z_lapse=pdf * (second * span * cdf - first),
        lapse_lapse=-second * cdf * cdf,
        guess=first * sf,
        z_guess=-pdf * (second * span * sf + first),
        guess_guess=-second * sf * sf,
        lapse_guess=second * cdf * sf,
    )


def by_point(shape: Shape, z: Array, guess: Array, lapse: Array, answers: tuple[Array, Array]) -> tuple[Array, Slopes]:
    """Return the log-likelihood of answers at z, and its derivatives.

    z has the shape (..., n_levels); rates broadcast to it.

    >>> at, none = np.zeros((1, 1)), np.zeros(1)
    >>> value, slopes = by_point(SHAPES["logistic"], at, none, none, (at + 3, at + 1))
    >>> float(slopes.z[0, 0]), float(slopes.zz[0, 0])
    (1.0, -1.0)
    """
    with np.errstate(all="ignore"):
        cdf, sf, pdf = linear(shape, z)
        span = 1 - guess - lapse
        yes, no = guess + span * cdf, lapse + span * sf
        n_yes, n_no = answers
        value = n_yes * np.log(yes) + n_no * np.log(no)
        k_yes, k_no = n_yes / yes, n_no / no
        slopes = _slopes(k_yes - k_no, k_yes / yes + k_no / no, (cdf, sf, pdf), span, shape.score(z))
        lost = ~(np.minimum(yes, no) > SMALLEST_LINEAR).all(axis=-1)  # negated, as a probability may be NaN
        if lost.any():
            some = (np.broadcast_to(values, z.shape)[lost] for values in (z, guess, lapse, n_yes, n_no))
            for values, exact in zip((value, *slopes), _by_logarithms(shape, *some), strict=True):
                values[lost] = exact
    return value, slopes


def _by_logarithms(shape: Shape, z: Array, guess: Array, lapse: Array, n_yes: Array, n_no: Array) -> list[Array]:
    logarithms, span = (shape.log_cdf(z), shape.log_sf(z), shape.log_pdf(z)), 1 - guess - lapse
    terms = []
    for sign, n, log_chance in zip((1, -1), (n_yes, n_no), log_mixture(*logarithms[:2], guess, lapse), strict=True):
        # Divide all parts by the probability of the answer: its log-likelihood then has slope 1 in psi.
        cdf, sf, pdf = (_ratio(part, log_chance) for part in logarithms)
        slopes = _slopes(sign * n, n, (cdf, sf, pdf), span, shape.score(z))
        terms.append((weighted(n, log_chance), *slopes))
    return [of_yes + of_no for of_yes, of_no in zip(*terms, strict=True)]


def _ratio(log_part: Array, log_chance: Array) -> Array:
    """Return exp(log_part - log_chance), limited to a finite value."""
    # If both underflowed, their difference is NaN; the part then counts as 0.
    difference = np.where(log_part == -np.inf, -np.inf, log_part - log_chance)
    return np.asarray(np.exp(np.minimum(difference, LARGEST_LOG_RATIO)))


def log_chances(shape: Shape, u: Array, theta: Array) -> tuple[Array, Array]:
    """Return log psi and log(1 - psi) at levels (..., n_levels)."""
    z, _, _ = _z(shape, u, theta)
    return log_mixture(shape.log_cdf(z), shape.log_sf(z), *_rates(theta))


def log_chances_by_curve(shape: Shape, u: Array, theta: Array) -> tuple[Array, Array]:
    """Return `log_chances` of curves that are equal along axis 0."""
    guess, lapse = _rates(theta)
    z, _, _ = _z(shape, u, theta[:1])
    if guess.min() == 0 or lapse.min() == 0:
        # With an asymptote of 0 a probability may underflow, so compute its logarithm directly.
        return log_mixture(shape.log_cdf(z), shape.log_sf(z), guess, lapse)
    span = 1 - guess - lapse
    cdf, sf, _ = linear(shape, z)
    yes, no = span * cdf, span * sf
    yes += guess  # in place, as the grid is large
    no += lapse
    return np.log(yes, out=yes), np.log(no, out=no)


def log_likelihood(shape: Shape, counts: Counts, theta: Array) -> Array:
    """Return the log-likelihood (n_sets,) without the binomial coefficient."""
    yes, no = log_chances(shape, counts.u, theta)
    terms = weighted(counts.n_yes, yes) + weighted(counts.n_trials - counts.n_yes, no)
    return np.asarray(terms.sum(axis=-1))


def saturated_log_likelihood(counts: Counts) -> Array:
    """Return the log-likelihood of a rate for each level."""
    return np.asarray(constant_log_likelihood(counts.n_yes, counts.n_trials).sum(axis=-1))


def constant_log_likelihood(k: Array, n: Array) -> Array:
    """Return the log-likelihood of k of n answers at the rate k / n."""
    return np.asarray(xlogy(k, k) + xlogy(n - k, n - k) - xlogy(n, n))


def _z(shape: Shape, u: Array, theta: Array) -> tuple[Array, Array, Array]:
    """Return z = z50 + (u - m) z_width exp(-v) and its derivatives in m and v."""
    with np.errstate(over="ignore"):
        slope = shape.z_width * np.exp(-theta[..., LOG_WIDTH, None])
    z = shape.z50 + (u - theta[..., THRESHOLD, None]) * slope
    return z, -slope, shape.z50 - z


def _rates(theta: Array) -> tuple[Array, Array]:
    return theta[..., GUESS, None], theta[..., LAPSE, None]


def expansion(shape: Shape, counts: Counts, theta: Array) -> Expansion:
    """Return the log-likelihood with its exact gradient and Hessian."""
    z, to_m, to_v = _z(shape, counts.u, theta)
    value, slopes = by_point(shape, z, *_rates(theta), (counts.n_yes, counts.n_trials - counts.n_yes))
    return _chain(value, slopes, to_m[..., 0], to_v)


def overdispersed_expansion(shape: Shape, counts: Counts, theta: Array, eta: Array) -> Expansion:
    """Return the beta-binomial `expansion` at eta (n_sets,)."""
    z, to_m, to_v = _z(shape, counts.u, theta)
    (guess, lapse), parts = _rates(theta), linear(shape, z)
    span = 1 - guess - lapse
    k, rest = counts.n_yes, counts.n_trials - counts.n_yes
    nu, a, b = _beta(guess + span * parts[0], lapse + span * parts[1], eta[:, None])
    # Derivatives in psi at each level: a increases and b decreases with psi.
    first = nu * (psi(k + a) - psi(a) - psi(rest + b) + psi(b))
    second = -(nu**2) * (_trigamma_rise(a, k) + _trigamma_rise(b, rest))
    slopes = _slopes(first, second, parts, span, shape.score(z))
    return _chain(_log_beta_ratio(k, rest, nu, a, b), slopes, to_m[..., 0], to_v)


def _chain(value: Array, by: Slopes, to_m: Array, to_v: Array) -> Expansion:
    """Sum over levels; convert derivatives to threshold and log width."""
    with np.errstate(over="ignore", invalid="ignore"):
        zz_v = by.zz * to_v
        z1, zv, lapse, guess = _sums(by.z, by.z * to_v, by.lapse, by.guess)
        zz, mv, vv = _sums(by.zz, zz_v, zz_v * to_v)
        zl, vl, ll = _sums(by.z_lapse, by.z_lapse * to_v, by.lapse_lapse)
        zg, vg, gg, lg = _sums(by.z_guess, by.z_guess * to_v, by.guess_guess, by.lapse_guess)
        # z is nonlinear in v: d2z/dm dv = -dz/dm, and d2z/dv2 = -dz/dv.
        mv, vv = (mv - z1) * to_m, vv - zv
        mm, ml, mg = zz * to_m * to_m, zl * to_m, zg * to_m
    rows = ((mm, mv, ml, mg), (mv, vv, vl, vg), (ml, vl, ll, lg), (mg, vg, lg, gg))
    hessian = np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
    return Expansion(value.sum(axis=-1), np.stack([z1 * to_m, zv, lapse, guess], axis=-1), hessian)


def _sums(*terms: Array) -> list[Array]:
    return [term.sum(axis=-1) for term in terms]


def information(shape: Shape, counts: Counts, theta: Array) -> Array:
    """Return the Fisher information (..., 4, 4) of answers at the levels."""
    z, to_m, to_v = _z(shape, counts.u, theta)
    (guess, lapse), parts = _rates(theta), linear(shape, z)
    span = 1 - guess - lapse
    variance = (guess + span * parts[0]) * (lapse + span * parts[1])
    with np.errstate(all="ignore"):
        share = np.where(variance > 0, counts.n_trials / variance, 0.0)
    none = np.zeros_like(z)
    # Minus the curvature of the expected answers, for which the slope is 0.
    return -_chain(none, _slopes(none, share, parts, span, none), to_m[..., 0], to_v).hessian


def log_weight(p: Array, q: Array, k: float, n: float, eta: float) -> Array:
    """Return the log probability of one order of beta-binomial answers.

    The mean probability is p = 1 - q.

    >>> from scipy.special import binom
    >>> round(float(binom(20, 15) * np.exp(log_weight(np.array(0.75), np.array(0.25), 15, 20, 0.2))), 9)
    0.148414569
    """
    return _log_beta_ratio(k, n - k, *_beta(p, q, eta))


def _beta(p: Array, q: Array, eta: Array | float) -> tuple[Array, Array, Array]:
    nu = np.asarray(1 / np.square(eta) - 1)
    return nu, nu * np.maximum(p, SMALLEST_CHANCE), nu * np.maximum(q, SMALLEST_CHANCE)


def _log_beta_ratio(k: Array | float, rest: Array | float, nu: Array, a: Array, b: Array) -> Array:
    """Return log B(k + a, rest + b) / B(a, b), where nu = a + b."""
    yes = gammaln(k + a) - gammaln(a)
    return np.asarray(yes + gammaln(rest + b) - gammaln(b) + gammaln(nu) - gammaln(k + rest + nu))


def _trigamma_rise(x: Array, count: Array) -> Array:
    """Return trigamma(x + count) - trigamma(x), exactly 0 for a count of 0."""
    return np.where(count > 0, polygamma(1, count + x) - polygamma(1, x), 0.0)
