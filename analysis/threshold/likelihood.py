"""Log-likelihood of psychometric functions with exact derivatives.

It is computed for many data sets at once.

A parameter vector is (m, v, l, g): threshold and log width on the scale of `Counts.u`, lapse rate, guess rate.

The probabilities are sums of positive parts, so they are computed on the linear scale. Data sets in which a probability
comes near the smallest float are computed again in log space.

Beta-binomial answers (Schuett et al. 2016): eta in [0, 1) is the overdispersion, nu = 1/eta^2 - 1, and the probability
of a block is drawn from Beta(nu psi, nu (1 - psi)); the variance of k is n psi (1 - psi) (1 + (n - 1) eta^2).
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from scipy.special import expit, gammaln, ndtr, polygamma, psi

from tactometry.psychometric import SHAPES, Shape, log_mixture

from ..arrays import Array, Expansion
from .counts import Counts

N_PARAMETERS = 4
THRESHOLD, LOG_WIDTH, LAPSE, GUESS = range(N_PARAMETERS)
BINOMIAL_BELOW = 1e-4
"""Below this the beta-binomial differs from the binomial by less than its own rounding."""
SMALLEST_CHANCE = 1e-100
SMALLEST_LINEAR = 1e-140
"""A chance whose square is still a float."""
LARGEST_LOG_RATIO = 300.0
ROOT_TWO_PI = float(np.sqrt(2 * np.pi))


# Derivatives along z, lapse and guess rate
class ByPoint(NamedTuple):
    """Log-likelihood with derivatives along z, lapse (l) and guess (g) rate."""

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
    """Return count * log_chance, and 0 for a count of 0 even at log 0."""
    with np.errstate(invalid="ignore"):
        return np.where(count > 0, count * log_chance, 0.0)


def by_point(shape: Shape, z: Array, guess: Array, lapse: Array, answers: tuple[Array, Array]) -> ByPoint:
    """Expand the log-likelihood of `answers` (n_yes, n_no) at z.

    z has the shape (..., n_levels); rates broadcast to it.

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
    """Return S, 1 - S and the density of S at z, all relatively precise."""
    return _LINEAR[shape](z)


def _linear(shape: Shape, z: Array, guess: Array, lapse: Array, answers: tuple[Array, Array]) -> tuple[ByPoint, Array]:
    """Return the expansion on the linear scale and the smaller probability."""
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
    # combined by yes + no = 1, so that nothing cancels even for tiny probabilities
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
    """Return the log probability of an answer and its derivatives.

    The order is z, zz, l, zl, ll, g, zg, gg, lg.
    """
    log_cdf, log_sf = shape.log_cdf(z), shape.log_sf(z)
    log_chance = log_mixture(log_cdf, log_sf, guess, lapse)[1 - answer]
    sign = 1.0 if answer else -1.0  # yes and no change in opposite directions
    density, up, down = (_ratio(log_part, log_chance) for log_part in (shape.log_pdf(z), log_cdf, log_sf))
    steep = (1 - guess - lapse) * density
    by_z, by_l, by_g = sign * steep, -sign * up, sign * down
    by_zz = sign * bend(steep, shape.score(z)) - steep * steep
    # As in `_linear`, the cross terms contain only the asymptote, so nothing cancels.
    if answer:
        log_at_guess, log_at_lapse = np.log(guess), np.log1p(-lapse)
    else:
        log_at_guess, log_at_lapse = np.log1p(-guess), np.log(lapse)
    by_zl = -sign * density * _ratio(log_at_guess, log_chance)
    by_zg = -sign * density * _ratio(log_at_lapse, log_chance)
    by_ll, by_gg, by_lg = -up * up, -down * down, up * down
    return log_chance, by_z, by_zz, by_l, by_zl, by_ll, by_g, by_zg, by_gg, by_lg


def bend(steep: Array, score: Array) -> Array:
    """Return steep * score, and 0 if the density has vanished."""
    with np.errstate(invalid="ignore"):
        return np.where(steep > 0, steep * score, 0.0)


def _ratio(log_part: Array, log_chance: Array) -> Array:
    """Return exp(log_part - log_chance), limited to finite values.

    An asymptote of 0 would make it infinite.
    """
    with np.errstate(invalid="ignore"):
        # If both have vanished their difference is NaN; the part then counts as 0.
        difference = np.where(log_part == -np.inf, -np.inf, log_part - log_chance)
    return np.asarray(np.exp(np.minimum(difference, LARGEST_LOG_RATIO)))


# Along the parameters
def log_chances(shape: Shape, u: Array, theta: Array) -> tuple[Array, Array]:
    """Return log psi and log(1 - psi) at levels (..., n_levels).

    Parameters have the shape (..., 4).
    """
    z, _, _ = _z(shape, u, theta)
    return log_mixture(shape.log_cdf(z), shape.log_sf(z), *_rates(theta))


def log_chances_by_curve(shape: Shape, u: Array, theta: Array) -> tuple[Array, Array]:
    """Return `log_chances` (n_curves, n_rates, n_levels).

    The curves of the parameters are equal along axis 1.
    """
    z, _, _ = _z(shape, u, theta[:, :1])
    guess, lapse = _rates(theta)
    if guess.min() == 0 or lapse.min() == 0:
        # Without an asymptote a probability may underflow; only its logarithm keeps the digits.
        return log_mixture(shape.log_cdf(z), shape.log_sf(z), guess, lapse)
    span = 1 - guess - lapse
    cdf, sf, _ = linear(shape, z)
    yes, no = span * cdf, span * sf
    yes += guess  # in place: a grid of starts is large
    no += lapse
    return np.log(yes, out=yes), np.log(no, out=no)


def log_likelihood(shape: Shape, counts: Counts, theta: Array) -> Array:
    """Return the log-likelihood (n_sets,) without the binomial coefficient."""
    yes, no = log_chances(shape, counts.u, theta)
    terms = weighted(counts.n_yes, yes) + weighted(counts.n_trials - counts.n_yes, no)
    return np.asarray(terms.sum(axis=-1))


def saturated_log_likelihood(counts: Counts) -> Array:
    """Return the largest log-likelihood of any function of the level."""
    return np.asarray(constant_log_likelihood(counts.n_yes, counts.n_trials).sum(axis=-1))


def constant_log_likelihood(k: Array, n: Array) -> Array:
    """Return the log-likelihood of k in n answers at rate k / n.

    It is 0 without trials.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        rest = n - k
        return weighted(k, np.log(k / n)) + weighted(rest, np.log(rest / n))


def _z(shape: Shape, u: Array, theta: Array) -> tuple[Array, Array, Array]:
    """Return z and its derivatives along threshold and log width.

    z = z50 + (u - m) z_width exp(-v); the derivatives have the shape (..., 1) along the threshold.
    """
    with np.errstate(over="ignore"):
        slope = shape.z_width * np.exp(-theta[..., LOG_WIDTH, None])
    z = shape.z50 + (u - theta[..., THRESHOLD, None]) * slope
    return z, -slope, shape.z50 - z


def _rates(theta: Array) -> tuple[Array, Array]:
    return theta[..., GUESS, None], theta[..., LAPSE, None]


def _matrix(rows: Sequence[Sequence[Array]]) -> Array:
    matrix = np.empty((*rows[0][0].shape, len(rows), len(rows)))
    for i, row in enumerate(rows):
        for j, entry in enumerate(row):
            matrix[..., i, j] = entry
    return matrix


def expansion(shape: Shape, counts: Counts, theta: Array) -> Expansion:
    """Return the log-likelihood with its exact gradient and Hessian."""
    z, to_m, to_v = _z(shape, counts.u, theta)
    answers = (counts.n_yes, counts.n_trials - counts.n_yes)
    with np.errstate(over="ignore", invalid="ignore"):
        return _chain(by_point(shape, z, *_rates(theta), answers), to_m[..., 0], to_v)


def _chain(by: ByPoint, to_m: Array, to_v: Array) -> Expansion:
    """Sum over levels and convert derivatives along z by the chain rule.

    The result is along threshold and log width.
    """
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
    """Return slopes of psi and psi (1 - psi) at each level.

    The slopes are along threshold, log width and lapse rate.
    """
    z, to_m, to_v = _z(shape, u, theta)
    guess, lapse = _rates(theta)
    cdf, sf, pdf = linear(shape, z)
    span = 1 - guess - lapse
    steep = span * pdf
    return steep * to_m, np.where(pdf > 0, steep * to_v, 0.0), -cdf, (guess + span * cdf) * (lapse + span * sf)


def curvature_of_chances(shape: Shape, u: Array, theta: Array) -> tuple[Array, Array, Array, Array]:
    """Return psi and 1 - psi with gradient and Hessian of psi.

    Shapes are (n, n_levels), (..., 4) and (..., 4, 4).
    """
    z, to_m, to_v = _z(shape, u, theta)
    guess, lapse = _rates(theta)
    cdf, sf, pdf = (np.exp(log_part(z)) for log_part in (shape.log_cdf, shape.log_sf, shape.log_pdf))
    span, nothing = 1 - guess - lapse, np.zeros_like(z)
    steep = span * pdf
    bent = span * bend(pdf, shape.score(z))
    mm = bent * to_m * to_m
    mv = bent * to_m * to_v - steep * to_m
    vv = bent * to_v * to_v - steep * to_v
    # Both rates reduce the span alike, so their cross terms are equal. psi is linear in the rates.
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
    """Return the log probability of one order of k yes in n answers.

    The mean probability is p = 1 - q.

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
    """Return log B(k + a, n - k + b) / B(a, b), where nu = a + b."""
    yes = gammaln(k + a) - gammaln(a)
    return np.asarray(yes + gammaln(n - k + b) - gammaln(b) + gammaln(nu) - gammaln(n + nu))


def _trigamma_rise(x: Array, count: Array) -> Array:
    """Return trigamma(x + count) - trigamma(x), exactly 0 for a count of 0."""
    return np.where(count > 0, polygamma(1, count + x) - polygamma(1, x), 0.0)


def overdispersed_expansion(shape: Shape, counts: Counts, theta: Array, eta: Array) -> Expansion:
    """Return the beta-binomial log-likelihood with gradient and Hessian.

    It is that at eta (n_sets,).
    """
    p, q, by, by_by = curvature_of_chances(shape, counts.u, theta)
    k, n = counts.n_yes, counts.n_trials
    nu = (1 / np.square(eta) - 1)[:, None]
    a = nu * np.maximum(p, SMALLEST_CHANCE)
    b = nu * np.maximum(q, SMALLEST_CHANCE)
    value = _log_beta_ratio(k, n, a, b, nu)
    # Derivatives along psi of each level, where a rises and b falls; then the chain rule to the parameters.
    first = nu * (psi(k + a) - psi(a) - psi(n - k + b) + psi(b))
    second = nu**2 * (_trigamma_rise(a, k) + _trigamma_rise(b, n - k))
    gradient = np.einsum("nl,nli->ni", first, by)
    steep = np.einsum("nl,nli,nlj->nij", second, by, by)
    bent = np.einsum("nl,nlij->nij", first, by_by)
    return Expansion(value.sum(axis=1), gradient, steep + bent)
