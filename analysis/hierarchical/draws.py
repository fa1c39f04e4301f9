"""Draws of the participants' thresholds, log widths and lapse rates from their posterior.

Laplace's approximation makes the intervals of participants 5 to 15 % too short after few trials. Draws from it are
weighed by the exact density of the participant's own answers and effects.
"""

from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from .inner import InnerMode, bordered, inner_at
from .model import GroupModel
from .posterior import Integrated

N_DRAWS = 1024
SEED = 1
WIDENED = 1.15
"""Draws have so many times the standard deviation of Laplace's approximation, which bounds their weights."""


@dataclass(frozen=True)
class CellDraws:
    """Predictors `points` (n, n_participants, n_conditions, 2) and lapse rates (n, n_participants) of draws with
    weights (n, n_participants), which sum to 1 over the draws of each participant."""

    points: Array
    lapse_rates: Array
    weights: Array

    @property
    def n_effective(self) -> Array:
        return np.asarray(1 / np.square(self.weights).sum(axis=0))


def draw_cells(model: GroupModel, found: Integrated, n_draws: int = N_DRAWS) -> CellDraws:
    """Return draws at hyperparameters that are chosen as often as their weights say."""
    rng = np.random.default_rng(SEED)
    steps = (np.arange(n_draws) + 0.5) / n_draws
    chosen = np.minimum(np.searchsorted(np.cumsum(found.weights), steps), len(found.weights) - 1)
    places, of_draw = np.unique(chosen, return_inverse=True)
    at = found.at[places]
    precision = model.precision(at.hyper)[0]
    inner = inner_at(model, at.hyper, precision, at.means, at.effects)
    hessian = bordered(model, model.information(inner.points, at.hyper), precision)
    root = WIDENED * np.linalg.cholesky(np.linalg.inv(hessian.local))[of_draw]
    normals = rng.standard_normal((n_draws, *at.effects.shape[1:]))
    away = (np.linalg.cholesky(at.covariance)[of_draw] @ rng.standard_normal((n_draws, at.means.shape[1], 1)))[..., 0]
    followed = np.einsum("niqp,np->niq", hessian.pulled[of_draw], away)  # the mode of the effects follows the means
    effects = at.effects[of_draw] - followed + np.einsum("niqr,nir->niq", root, normals)
    hyper, priors = at.hyper[of_draw], precision[of_draw]
    drawn = inner_at(model, hyper, priors, at.means[of_draw] + away, effects)
    # Laplace's density of the participant's answers at the means drawn, which is in the weight of the point already.
    score = np.einsum("cdp,nicd->nip", model.fixed, inner.at.gradient)[of_draw]
    bent = np.einsum("np,nipr,nr->ni", away, hessian.own[of_draw], away, optimize=True)
    before = _log_density(inner, precision)[of_draw] + np.einsum("nip,np->ni", score, away) - 0.5 * bent
    log_weights = _log_density(drawn, priors) + 0.5 * np.square(normals).sum(axis=2) - before
    weights = np.exp(log_weights - log_weights.max(axis=0))
    return CellDraws(drawn.points[..., :2], model.lapses(hyper, effects), weights / weights.sum(axis=0))


def _log_density(inner: InnerMode, precision: Array) -> Array:
    """Return that of the answers and effects of each participant (n, n_participants)."""
    bound = np.einsum("niq,nqr,nir->ni", inner.effects, precision, inner.effects, optimize=True)
    return np.asarray(inner.at.value.sum(axis=2) - 0.5 * bound)


def weighted_quantiles(values: Array, weights: Array, share: float) -> Array:
    """Return quantiles over the first axis of values (n, ...) with weights of the same shape."""
    order = np.argsort(values, axis=0)
    values, reached = np.take_along_axis(values, order, 0), np.cumsum(np.take_along_axis(weights, order, 0), axis=0)
    place = np.minimum((reached < share).sum(axis=0, keepdims=True), len(values) - 1)
    return np.asarray(np.take_along_axis(values, place, 0)[0])
