"""Binomial log-likelihood of psychometric functions for many data sets at once, with exact derivatives.

A parameter vector is (m, v, l, g): threshold and log width on the scale of `Counts.u`, lapse rate, guess
rate.

Beta-binomial answers: the chance of a level varies from block to block (Schuett et al. 2016).

eta in [0, 1) is the overdispersion: nu = 1/eta^2 - 1, and the chance of a block is drawn from
Beta(nu psi, nu (1 - psi)); the variance of k is n psi (1 - psi) (1 + (n - 1) eta^2). eta = 0 is the binomial.
"""

from collections.abc import Sequence

import numpy as np
from scipy.special import gammaln, polygamma, psi

from tactometry.psychometric import Shape, log_mixture

from ..arrays import Array, Expansion
from .chances import ByPoint, bend, by_point, linear, weighted
from .counts import Counts

N_PARAMETERS = 4
THRESHOLD, LOG_WIDTH, LAPSE, GUESS = range(N_PARAMETERS)
BINOMIAL_BELOW = 1e-4
"""Below this the beta-binomial differs from the binomial by less than its own rounding."""
SMALLEST_CHANCE = 1e-100


def log_chances(shape: Shape, u: Array, theta: Array) -> tuple[Array, Array]:
    """log psi and log(1 - psi) at levels (..., n_levels) for parameters (..., 4)."""
    z, _, _ = _z(shape, u, theta)
    return log_mixture(shape.log_cdf(z), shape.log_sf(z), *_rates(theta))


def log_chances_by_curve(shape: Shape, u: Array, theta: Array) -> tuple[Array, Array]:
    """As `log_chances` (n_curves, n_rates, n_levels), where threshold and width are the same along the second axis."""
    z, _, _ = _z(shape, u, theta[:, :1])
    guess, lapse = _rates(theta)
    if guess.min() == 0 or lapse.min() == 0:
        # Without an asymptote to hold it up a chance may underflow, and keeps its digits only as a logarithm.
        return log_mixture(shape.log_cdf(z), shape.log_sf(z), guess, lapse)
    span = 1 - guess - lapse
    cdf, sf, _ = linear(shape, z)
    yes, no = span * cdf, span * sf
    yes += guess  # in place: a grid of starts is large
    no += lapse
    return np.log(yes, out=yes), np.log(no, out=no)


def log_likelihood(shape: Shape, counts: Counts, theta: Array) -> Array:
    """Sum of k log psi + (n - k) log(1 - psi), without the binomial coefficient; shape (n_sets,)."""
    yes, no = log_chances(shape, counts.u, theta)
    terms = weighted(counts.n_yes, yes) + weighted(counts.n_trials - counts.n_yes, no)
    return np.asarray(terms.sum(axis=-1))


def saturated_log_likelihood(counts: Counts) -> Array:
    """The largest log-likelihood any function of the level can reach; shape (n_sets,)."""
    return np.asarray(constant_log_likelihood(counts.n_yes, counts.n_trials).sum(axis=-1))


def constant_log_likelihood(k: Array, n: Array) -> Array:
    """Of k in n answers at their own rate k / n; 0 without trials."""
    with np.errstate(divide="ignore", invalid="ignore"):
        rest = n - k
        return weighted(k, np.log(k / n)) + weighted(rest, np.log(rest / n))


def _z(shape: Shape, u: Array, theta: Array) -> tuple[Array, Array, Array]:
    """z = z50 + (u - m) z_width exp(-v) at each level, and its derivatives: along the threshold (..., 1), the same at
    all levels, and along the log width."""
    with np.errstate(over="ignore"):
        slope = shape.z_width * np.exp(-theta[..., LOG_WIDTH, None])
    z = shape.z50 + (u - theta[..., THRESHOLD, None]) * slope
    return z, -slope, shape.z50 - z


def _rates(theta: Array) -> tuple[Array, Array]:
    """Guess and lapse rates (..., 1)."""
    return theta[..., GUESS, None], theta[..., LAPSE, None]


def _matrix(rows: Sequence[Sequence[Array]]) -> Array:
    """Entries (...) as (..., n, n)."""
    matrix = np.empty((*rows[0][0].shape, len(rows), len(rows)))
    for i, row in enumerate(rows):
        for j, entry in enumerate(row):
            matrix[..., i, j] = entry
    return matrix


def expansion(shape: Shape, counts: Counts, theta: Array) -> Expansion:
    """The log-likelihood with its exact gradient and Hessian."""
    z, to_m, to_v = _z(shape, counts.u, theta)
    answers = (counts.n_yes, counts.n_trials - counts.n_yes)
    with np.errstate(over="ignore", invalid="ignore"):
        return _chain(by_point(shape, z, *_rates(theta), answers), to_m[..., 0], to_v)


def _chain(by: ByPoint, to_m: Array, to_v: Array) -> Expansion:
    """From derivatives along z to those along threshold and log width; summed over the levels."""
    zz_v = by.zz * to_v
    z1, zv, lapse, guess = _sums(by.z, by.z * to_v, by.lapse, by.guess)
    zz, mv, vv = _sums(by.zz, zz_v, zz_v * to_v)
    zl, vl, ll = _sums(by.z_lapse, by.z_lapse * to_v, by.lapse_lapse)
    zg, vg, gg, lg = _sums(by.z_guess, by.z_guess * to_v, by.guess_guess, by.lapse_guess)
    # z itself bends along v: d2z/dm dv = -dz/dm, and d2z/dv2 = -dz/dv.
    mv, vv = (mv - z1) * to_m, vv - zv
    mm, ml, mg = zz * to_m * to_m, zl * to_m, zg * to_m
    rows = (
        (mm, mv, ml, mg),
        (mv, vv, vl, vg),
        (ml, vl, ll, lg),
        (mg, vg, lg, gg),
    )
    gradient = np.stack([z1 * to_m, zv, lapse, guess], axis=-1)
    return Expansion(by.value.sum(axis=-1), gradient, _matrix(rows))


def _sums(*terms: Array) -> list[Array]:
    return [term.sum(axis=-1) for term in terms]


def chance_slopes(shape: Shape, u: Array, theta: Array) -> tuple[Array, Array, Array, Array]:
    """Return slopes of psi along threshold, log width and lapse rate, and psi (1 - psi), at each level."""
    z, to_m, to_v = _z(shape, u, theta)
    guess, lapse = _rates(theta)
    cdf, sf, pdf = linear(shape, z)
    span = 1 - guess - lapse
    steep = span * pdf
    return steep * to_m, np.where(pdf > 0, steep * to_v, 0.0), -cdf, (guess + span * cdf) * (lapse + span * sf)


def curvature_of_chances(shape: Shape, u: Array, theta: Array) -> tuple[Array, Array, Array, Array]:
    """psi and 1 - psi (n, n_levels), and gradient (..., 4) and Hessian (..., 4, 4) of psi at each level."""
    z, to_m, to_v = _z(shape, u, theta)
    guess, lapse = _rates(theta)
    cdf, sf, pdf = (np.exp(log_part(z)) for log_part in (shape.log_cdf, shape.log_sf, shape.log_pdf))
    span, nothing = 1 - guess - lapse, np.zeros_like(z)
    steep = span * pdf
    bent = span * bend(pdf, shape.score(z))
    mm = bent * to_m * to_m
    mv = bent * to_m * to_v - steep * to_m
    vv = bent * to_v * to_v - steep * to_v
    # Either rate takes as much from the span: the cross terms of lapse and guess are the same. Along the rates psi is
    # straight.
    ml, vl = -pdf * to_m, -pdf * to_v
    rows = [
        [mm, mv, ml, ml],
        [mv, vv, vl, vl],
        [ml, vl, nothing, nothing],
        [ml, vl, nothing, nothing],
    ]
    gradient = np.stack([steep * to_m, steep * to_v, -cdf, sf], axis=-1)
    return guess + span * cdf, lapse + span * sf, gradient, _matrix(rows)


def log_weight(p: Array, q: Array, k: Array | float, n: Array | float, eta: float) -> Array:
    """Log chance of one order of k yes in n answers at the mean chance p = 1 - q, elementwise.

    >>> from scipy.special import binom
    >>> round(float(binom(20, 15) * np.exp(log_weight(np.array(0.75), np.array(0.25), 15, 20, 0.2))), 9)
    0.148414569
    """
    if eta < BINOMIAL_BELOW:
        return np.asarray(k * np.log(p) + (n - k) * np.log(q))
    nu = np.asarray(1 / eta**2 - 1)
    a = nu * np.maximum(p, SMALLEST_CHANCE)
    b = nu * np.maximum(q, SMALLEST_CHANCE)
    return _log_beta_ratio(k, n, a, b, nu)


def _log_beta_ratio(k: Array | float, n: Array | float, a: Array, b: Array, nu: Array) -> Array:
    """The logarithm of B(k + a, n - k + b) / B(a, b), where nu = a + b."""
    yes = gammaln(k + a) - gammaln(a)
    return np.asarray(yes + gammaln(n - k + b) - gammaln(b) + gammaln(nu) - gammaln(n + nu))


def _trigamma_rise(x: Array, count: Array) -> Array:
    """From x to x + count; exactly 0 without a count."""
    return np.where(count > 0, polygamma(1, count + x) - polygamma(1, x), 0.0)


def overdispersed_expansion(shape: Shape, counts: Counts, theta: Array, eta: Array) -> Expansion:
    """The log-likelihood at eta (n_sets,), with gradient and Hessian along (threshold, log width, lapse,
    guess)."""
    p, q, by, by_by = curvature_of_chances(shape, counts.u, theta)
    k, n = counts.n_yes, counts.n_trials
    nu = (1 / np.square(eta) - 1)[:, None]
    a = nu * np.maximum(p, SMALLEST_CHANCE)
    b = nu * np.maximum(q, SMALLEST_CHANCE)
    value = _log_beta_ratio(k, n, a, b, nu)
    # Along psi of each level, where a rises and b falls; then the chain rule from psi to the parameters.
    first = nu * (psi(k + a) - psi(a) - psi(n - k + b) + psi(b))
    second = nu**2 * (_trigamma_rise(a, k) + _trigamma_rise(b, n - k))
    gradient = np.einsum("nl,nli->ni", first, by)
    steep = np.einsum("nl,nli,nlj->nij", second, by, by)
    bent = np.einsum("nl,nlij->nij", first, by_by)
    return Expansion(value.sum(axis=1), gradient, steep + bent)
