"""Binomial log-likelihood of psychometric functions for many data sets at once, with exact derivatives.

A parameter vector is (m, v, l, g): threshold and log width on the scale of `Counts.u`, lapse rate, guess
rate. All ratios are exponentials of differences of logarithms, so that nothing overflows or is lost in a
tail.
"""

from dataclasses import dataclass

import numpy as np

from tactometry.analysis.counts import Array, Counts
from tactometry.psychometric import Shape, log_mixture

N_PARAMETERS = 4
THRESHOLD, LOG_WIDTH, LAPSE, GUESS = range(N_PARAMETERS)
_LARGEST_LOG_RATIO = 300.0


def weighted(count: Array, log_chance: Array) -> Array:
    """count * log_chance, where no count gives 0 even at log 0."""
    with np.errstate(invalid="ignore"):
        return np.where(count > 0, count * log_chance, 0.0)


def log_chances(shape: Shape, u: Array, theta: Array) -> tuple[Array, Array]:
    """log psi and log(1 - psi) at levels (..., n_levels) for parameters (..., 4)."""
    z = _z(shape, u, theta)
    return log_mixture(shape.log_cdf(z), shape.log_sf(z), theta[..., LAPSE + 1, None], theta[..., LAPSE, None])


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
        return weighted(k, np.log(k / n)) + weighted(n - k, np.log((n - k) / n))


def _z(shape: Shape, u: Array, theta: Array) -> Array:
    with np.errstate(over="ignore"):
        slope = shape.z_width * np.exp(-theta[..., LOG_WIDTH])
    return shape.z50 + (u - theta[..., THRESHOLD, None]) * slope[..., None]


@dataclass(frozen=True)
class Expansion:
    """Value (n,), gradient (n, 4) and Hessian (n, 4, 4) of a log density."""

    value: Array
    gradient: Array
    hessian: Array

    def __add__(self, other: "Expansion") -> "Expansion":
        return Expansion(self.value + other.value, self.gradient + other.gradient, self.hessian + other.hessian)


def expansion(shape: Shape, counts: Counts, theta: Array) -> Expansion:
    """The log-likelihood with its exact gradient and Hessian."""
    z = _z(shape, counts.u, theta)
    yes, no = _one_answer(shape, z, theta, 1), _one_answer(shape, z, theta, 0)
    n_yes, n_no = counts.n_yes, counts.n_trials - counts.n_yes
    value = (weighted(n_yes, yes[0]) + weighted(n_no, no[0])).sum(axis=-1)
    by_z = [n_yes * a + n_no * b for a, b in zip(yes[1:], no[1:], strict=True)]
    return Expansion(value, *_chain(shape, z, theta, by_z))


def _one_answer(shape: Shape, z: Array, theta: Array, answer: int) -> tuple[Array, ...]:
    """log chance of an answer and its derivatives: z, zz, l, zl, ll, g, zg, gg, lg."""
    guess, lapse = theta[..., GUESS, None], theta[..., LAPSE, None]
    log_cdf, log_sf = shape.log_cdf(z), shape.log_sf(z)
    chance = log_mixture(log_cdf, log_sf, guess, lapse)[1 - answer]
    sign = 1.0 if answer else -1.0
    density, up, down = (_ratio(part, chance) for part in (shape.log_pdf(z), log_cdf, log_sf))
    steep = (1 - guess - lapse) * density
    by_z, by_l, by_g = sign * steep, -sign * up, sign * down
    by_zz = sign * _bend(steep, shape.score(z)) - steep * steep
    if answer:
        by_zl, by_zg = -density * _ratio(np.log(guess), chance), -density * _ratio(np.log1p(-lapse), chance)
    else:
        by_zl, by_zg = density * _ratio(np.log1p(-guess), chance), density * _ratio(np.log(lapse), chance)
    return chance, by_z, by_zz, by_l, by_zl, -up * up, by_g, by_zg, -down * down, up * down


def _bend(steep: Array, score: Array) -> Array:
    """steep * score, 0 where the density has vanished: it does so faster than its logarithm bends."""
    with np.errstate(invalid="ignore"):
        return np.where(steep > 0, steep * score, 0.0)


def _ratio(log_part: Array, log_chance: Array) -> Array:
    """exp(log_part - log_chance), bounded: an asymptote of 0 makes it infinite."""
    with np.errstate(invalid="ignore"):
        difference = np.where(log_part == -np.inf, -np.inf, log_part - log_chance)
    return np.asarray(np.exp(np.minimum(difference, _LARGEST_LOG_RATIO)))


def _chain(shape: Shape, z: Array, theta: Array, by_z: list[Array]) -> tuple[Array, Array]:
    """From derivatives along z to those along threshold and log width; summed over the levels."""
    dz, dzz, dl, dzl, dll, dg, dzg, dgg, dlg = by_z
    to_m = np.broadcast_to(-shape.z_width * np.exp(-theta[..., LOG_WIDTH, None]), z.shape)
    to_v = shape.z50 - z
    gradient = np.stack([dz * to_m, dz * to_v, dl, dg], axis=-1).sum(axis=-2)
    mv = dzz * to_m * to_v - dz * to_m
    rows = [
        [dzz * to_m * to_m, mv, dzl * to_m, dzg * to_m],
        [mv, dzz * to_v * to_v - dz * to_v, dzl * to_v, dzg * to_v],
        [dzl * to_m, dzl * to_v, dll, dlg],
        [dzg * to_m, dzg * to_v, dlg, dgg],
    ]
    hessian = np.stack([np.stack([part.sum(axis=-1) for part in row], axis=-1) for row in rows], axis=-2)
    return gradient, hessian


def curvature_of_chances(shape: Shape, u: Array, theta: Array) -> tuple[Array, Array, Array, Array]:
    """psi and 1 - psi (n, n_levels), and gradient (..., 4) and Hessian (..., 4, 4) of psi at each level."""
    z = _z(shape, u, theta)
    guess, lapse = theta[..., GUESS, None], theta[..., LAPSE, None]
    cdf, sf, pdf = (np.exp(part(z)) for part in (shape.log_cdf, shape.log_sf, shape.log_pdf))
    span, nothing = 1 - guess - lapse, np.zeros_like(z)
    to_m = np.broadcast_to(-shape.z_width * np.exp(-theta[..., LOG_WIDTH, None]), z.shape)
    to_v = shape.z50 - z
    steep, bend = span * pdf, span * _bend(pdf, shape.score(z))
    mv, ml, vl = bend * to_m * to_v - steep * to_m, -pdf * to_m, -pdf * to_v
    rows = [
        [bend * to_m * to_m, mv, ml, ml],
        [mv, bend * to_v * to_v - steep * to_v, vl, vl],
        [ml, vl, nothing, nothing],
        [ml, vl, nothing, nothing],
    ]
    hessian = np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
    gradient = np.stack([steep * to_m, steep * to_v, -cdf, sf], axis=-1)
    return guess + span * cdf, lapse + span * sf, gradient, hessian
