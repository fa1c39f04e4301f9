"""Marginal likelihoods of clustered answers by adaptive Gauss-Hermite quadrature: the reference of Laplace's
approximation, which is its case of one node (Pinheiro and Chao 2006, Journal of Computational and Graphical Statistics
15(1), 58-81)."""

from collections.abc import Callable
from itertools import product

import numpy as np
from scipy.optimize import minimize

from tactometry.analysis.counts import Array
from tactometry.analysis.laplace import ILL, MixedFit, MixedModel, inner_mode, symmetric_inverse

STEP = 1e-3


def log_marginal_by_quadrature(model: MixedModel, parameters: Array, n_nodes: int) -> float:
    """With `n_nodes` along each random effect; n_nodes ** n_random evaluations of every unit."""
    inner = inner_mode(model, parameters)
    beta, shared, _ = model.parts(parameters)
    offset, n = model.fixed @ beta, model.random.shape[-1]
    points, weights = np.polynomial.hermite.hermgauss(n_nodes)
    root = np.linalg.inv(np.swapaxes(np.linalg.cholesky(inner.precision), 1, 2))
    terms = []
    for places in product(range(n_nodes), repeat=n):
        x = points[list(places)]
        effects = inner.effects + np.sqrt(2) * root @ x
        answers = model.log_likelihood(model.points(offset, inner.loads, effects, shared)).value.sum(axis=1)
        density = answers - 0.5 * np.square(effects).sum(axis=1)
        terms.append(density + x @ x + np.log(weights[list(places)]).sum())
    half_log_det = 0.5 * np.linalg.slogdet(inner.precision)[1]
    return float((np.logaddexp.reduce(terms, axis=0) - half_log_det - 0.5 * n * np.log(np.pi)).sum())


def maximise_by_quadrature(model: MixedModel, start: MixedFit, n_nodes: int) -> MixedFit:
    """From Laplace's maximum, by quasi-Newton steps on differences."""

    def loss(parameters: Array) -> float:
        value = log_marginal_by_quadrature(model, parameters, n_nodes)
        return -value if np.isfinite(value) else -ILL

    found = minimize(loss, start.parameters, method="BFGS", options={"hess_inv0": start.covariance, "gtol": 1e-4})
    covariance, flatness = symmetric_inverse(_hessian(loss, found.x))
    gradient = float(np.abs(found.jac).max())
    inner = inner_mode(model, found.x)
    return MixedFit(found.x, covariance, -float(found.fun), flatness, gradient, inner)


def _hessian(loss: Callable[[Array], float], at: Array) -> Array:
    n, matrix = len(at), np.empty((len(at), len(at)))
    steps = STEP * np.eye(n)
    for i in range(n):
        for j in range(i + 1):
            corners = [loss(at + a * steps[i] + b * steps[j]) for a, b in product((1, -1), repeat=2)]
            matrix[i, j] = matrix[j, i] = (corners[0] - corners[1] - corners[2] + corners[3]) / (4 * STEP**2)
    return matrix
