"""Means and effects of all participants, given hyperparameters: mode and curvature, at many hyperparameters at once.

The log density is summed over participants who share the means alone, so that its negative Hessian is bordered: the
effects of each participant are eliminated first (Schur's complement), then the means are found.
"""

from dataclasses import dataclass

import numpy as np

from ..arrays import Array, Expansion, Rows
from .model import GroupModel

MAX_STEPS = 60
SMALL_DECREMENT = 1e-9
"""The step that follows a decrement of this size squares it."""


FIRST_DAMPING, SMALLEST_DAMPING = 1e-2, 1e-4
"""A smaller damping is none: Newton's own step alone squares the error, and may end the search."""


@dataclass(frozen=True)
class InnerMode(Rows):
    """The mode at hyperparameters, one row for each point.

    `value` (n,) is the log density, `means` (n, n_fixed), `effects` (n, n_participants, n_random), `points` the
    predictors of all cells and `at` their log-likelihoods.
    """

    value: Array
    means: Array
    effects: Array
    points: Array
    at: Expansion


@dataclass(frozen=True)
class Bordered:
    """The negative Hessian: `local` (n, n_participants, q, q) of effects, `cross` (n, n_participants, q, p) with the
    means, `pulled` the inverse of the one times the other, `schur` (n, p, p) of the means at the effects that follow
    them, and `own` the part of it that each participant adds."""

    local: Array
    cross: Array
    pulled: Array
    own: Array
    schur: Array

    @property
    def half_log_determinant(self) -> Array:
        """Half of the log determinant (n,), infinite where the Hessian is not definite."""
        signs, logs = np.linalg.slogdet(self.local)
        sign, log = np.linalg.slogdet(self.schur)
        is_definite = (signs > 0).all(axis=1) & (sign > 0)
        return np.where(is_definite, 0.5 * (logs.sum(axis=1) + log), np.inf)


def find_inner(model: GroupModel, hyper: Array, means: Array, effects: Array) -> InnerMode:
    """Damped Newton steps from `means` and `effects`, each point with its own damping until it has converged."""
    precision, n = model.precision(hyper)[0], len(hyper)
    start = np.broadcast_to(means, (n, means.shape[-1])), np.broadcast_to(effects, (n, *effects.shape[-2:]))
    found = inner_at(model, hyper, precision, *start)
    damping, left, here = np.zeros(n), np.arange(n), found
    for _ in range(MAX_STEPS):
        *steps, decrement = _step(model, here, precision[left], damping)
        there = inner_at(model, hyper[left], precision[left], here.means + steps[0], here.effects + steps[1])
        rounding = 1e-12 * (1 + np.abs(here.value))
        better = (decrement >= 0) & (there.value >= here.value - rounding)
        here = there.where(better, here)
        found = found.replaced(left, here)
        is_near = (np.abs(decrement) <= SMALL_DECREMENT * (1 + np.abs(here.value))) & (damping < SMALLEST_DAMPING)
        damping = np.where(better, damping / 10, np.maximum(10 * damping, FIRST_DAMPING))
        going = ~(is_near | (damping > 1e10))
        left, damping, here = left[going], damping[going], here[going]
        if not len(left):
            break
    return found


def inner_at(model: GroupModel, hyper: Array, precision: Array, means: Array, effects: Array) -> InnerMode:
    """Return the log density and its parts at means and effects."""
    offset = model.offsets(hyper)[:, None] + np.einsum("cdp,np->ncd", model.fixed, means)
    points = offset[:, None] + np.einsum("cdq,niq->nicd", model.random, effects)
    at = model.log_likelihood(points, hyper)
    mean, by_mean = (part[: means.shape[1]] for part in model.means_prior)
    bound = 0.5 * np.einsum("niq,nqr,nir->n", effects, precision, effects, optimize=True)
    bound = bound + 0.5 * np.square(means - mean) @ by_mean
    value = at.value.sum(axis=(1, 2)) - bound
    return InnerMode(np.where(np.isfinite(value), value, -np.inf), means, effects, points, at)


def bordered(model: GroupModel, curvature: Array, precision: Array, damping: Array | float = 0.0) -> Bordered:
    """Return the negative Hessian of a curvature of the cells."""
    x, z = model.fixed, model.random
    c, d, q = z.shape
    n, n_people = curvature.shape[:2]
    bent_z = (curvature @ z).reshape(n, n_people, c * d, q)
    bent_x = (curvature @ x).reshape(n, n_people, c * d, -1)
    z_all, x_all = z.reshape(c * d, q).T, x.reshape(c * d, -1).T
    more = np.broadcast_to(np.asarray(damping), (n,))[:, None, None]
    # A damping multiplies the priors' curvature as well: effects have scales of their own.
    local = z_all @ bent_z + (precision * (1 + more))[:, None]
    cross = z_all @ bent_x
    pulled = np.linalg.solve(local, cross)
    own = x_all @ bent_x - np.swapaxes(cross, 2, 3) @ pulled
    prior = (1 + more) * np.diag(model.means_prior[1][: x.shape[2]])
    return Bordered(local, cross, pulled, own, own.sum(axis=1) + prior)


def _step(model: GroupModel, here: InnerMode, precision: Array, damping: Array) -> tuple[Array, Array, Array]:
    mean, by_mean = (part[: here.means.shape[1]] for part in model.means_prior)
    slope = here.at.gradient
    g_effects = np.einsum("cdq,nicd->niq", model.random, slope) - here.effects @ precision
    g_means = np.einsum("cdp,nicd->np", model.fixed, slope) - by_mean * (here.means - mean)
    hessian = bordered(model, -here.at.hessian, precision, damping)
    alone = np.linalg.solve(hessian.local, g_effects[..., None])
    rest = g_means - np.einsum("niqp,niq->np", hessian.cross, alone[..., 0])
    by_means = np.linalg.solve(hessian.schur, rest[..., None])
    by_effects = (alone - hessian.pulled @ by_means[:, None])[..., 0]
    decrement = (by_means[..., 0] * g_means).sum(axis=1) + (by_effects * g_effects).sum(axis=(1, 2))
    return by_means[..., 0], by_effects, decrement
