"""Marginal likelihoods of clustered answers by adaptive Gauss-Hermite quadrature: the reference of Laplace's
approximation, which is its case of one node (Pinheiro and Chao 2006, Journal of Computational and Graphical Statistics
15(1), 58-81)."""

from functools import partial
from itertools import product

import numpy as np

from ..arrays import Array, Expansion
from .laplace import ClusteredModel, Inner, MixedFit, maximise, with_prior


def log_marginal_by_quadrature(
    model: ClusteredModel, parameters: Array, inner: Inner, *, n_nodes: int
) -> tuple[float, Array]:
    """With `n_nodes` along each random effect (n_nodes ** n_random evaluations of every unit), and its gradient: the
    mean of the complete data's, over the random effects given the answers (Fisher's identity)."""
    beta, shared, _ = model.parts(parameters)
    offset, n = model.fixed @ beta, model.random.shape[-1]
    points, weights = np.polynomial.hermite.hermgauss(n_nodes)
    root = np.linalg.inv(np.swapaxes(np.linalg.cholesky(inner.precision), 1, 2))
    terms, slopes = [], []
    for places in product(range(n_nodes), repeat=n):
        x = points[list(places)]
        effects = inner.effects + np.sqrt(2) * root @ x
        at = model.log_likelihood(model.points(offset, inner.loads, effects, shared))
        density = at.value.sum(axis=1) - 0.5 * np.square(effects).sum(axis=1)
        # The weights are those of integrals with a factor exp(-x^2), which is taken out again.
        terms.append(density + x @ x + np.log(weights[list(places)]).sum())
        slopes.append(_slope(model, at, effects))
    total = np.logaddexp.reduce(terms, axis=0)
    half_log_det = 0.5 * np.linalg.slogdet(inner.precision)[1]
    value = float((total - half_log_det - 0.5 * n * np.log(np.pi)).sum())
    gradient = np.einsum("nc,ncp->p", np.exp(np.array(terms) - total), slopes)
    return with_prior(model, parameters, value, gradient)


def _slope(model: ClusteredModel, at: Expansion, effects: Array) -> Array:
    """The gradient (n_clusters, n_parameters) of the answers' log-likelihood at some random effects."""
    d = model.fixed.shape[2]
    by_eta = at.gradient[..., :d]
    by_scale = np.einsum("csaq,csa,cr->cqr", model.random, by_eta, effects, optimize=True)
    return np.concatenate(
        [
            np.einsum("csap,csa->cp", model.fixed, by_eta),
            at.gradient[..., d:].sum(axis=1),
            np.einsum("kqr,cqr->ck", model.basis, by_scale),
        ],
        axis=1,
    )


def maximise_by_quadrature(model: ClusteredModel, start: MixedFit, n_nodes: int) -> MixedFit:
    """From Laplace's maximum."""
    return maximise(model, start.parameters, partial(log_marginal_by_quadrature, n_nodes=n_nodes))
