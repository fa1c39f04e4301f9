"""Marginal likelihoods of clustered answers by Laplace's approximation, with exact derivatives.

A unit (a row of counts, or a participant's cell) has d predictors, eta = X beta + Z Lambda u, where u ~ N(0, 1) are the
random effects of its cluster and Lambda = sum theta_k B_k their scale (lme4's parameterisation; Bates, Maechler, Bolker
and Walker 2015, Journal of Statistical Software 67(1)), and shares some further parameters with all others. The
gradient of the approximation follows the mode of u by the implicit function theorem. Third derivatives are
central differences of exact second ones; nothing else is differenced but the outer Hessian.

Marginal likelihoods of clustered answers by adaptive Gauss-Hermite quadrature: the reference of Laplace's
approximation, which is its case of one node (Pinheiro and Chao 2006, Journal of Computational and Graphical Statistics
15(1), 58-81).
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import product
from typing import Any

import numpy as np

from ..arrays import Array, Expansion, Rows

DIFFERENCE = 1e-4  # of central differences: their error goes with its square, that of rounding with its inverse
MAX_INNER_STEPS = 60
SMALL_INNER_DECREMENT = 1e-9
"""The step that follows a decrement of this size squares it."""
GRADIENT_TOLERANCE = 1e-5
MAX_POLISHING = 4
MAX_RESTARTS = 5
FLATTEST = 1e-8
ILL = -1e12
"""The value of parameters under which the answers are impossible."""


@dataclass(frozen=True)
class ClusteredModel:
    """Clusters by slots of units; a slot that is not used has X = Z = 0 and a log-likelihood of 0.

    Parameters
    ----------
    log_likelihood : function
        Of points (n_clusters, n_slots, d + n_shared), with derivatives along the last axis.
    fixed, random : ndarray
        X (n_clusters, n_slots, d, n_fixed) and Z (n_clusters, n_slots, d, n_random).
    basis : ndarray
        B (n_theta, n_random, n_random).
    n_shared : int
        Parameters that all units share, after the predictors.
    log_prior : function or None
        Value and gradient of the log prior of the fixed effects and the shared parameters.
    information : function or None
        Of points, the negative curvature (n_clusters, n_slots, d, d) for the determinant in place of the observed one
        (lme4 takes the expected information, which differs for any link but the canonical).
    """

    log_likelihood: Callable[[Array], Expansion]
    fixed: Array
    random: Array
    basis: Array
    n_shared: int = 0
    log_prior: Callable[[Array], tuple[float, Array]] | None = None
    information: Callable[[Array], Array] | None = None

    def curvature(self, points: Array) -> Array:
        """The negative curvature (n_clusters, n_slots, d, d) that enters the determinant."""
        d = self.fixed.shape[2]
        if self.information is None:
            return -self.log_likelihood(points).hessian[..., :d, :d]
        return self.information(points)

    @property
    def n_fixed(self) -> int:
        return int(self.fixed.shape[-1])

    @property
    def n_parameters(self) -> int:
        return self.n_fixed + self.n_shared + len(self.basis)

    def parts(self, parameters: Array) -> tuple[Array, Array, Array]:
        """Fixed effects, shared parameters, theta."""
        first, second = self.n_fixed, self.n_fixed + self.n_shared
        return parameters[:first], parameters[first:second], parameters[second:]

    def scale(self, theta: Array) -> Array:
        """Lambda (n_random, n_random)."""
        return np.asarray(np.tensordot(theta, self.basis, axes=1), dtype=np.float64)

    def points(self, offset: Array, loads: Array, effects: Array, shared: Array) -> Array:
        eta = offset + np.einsum("csdq,cq->csd", loads, effects)
        of_units = np.broadcast_to(shared, (*eta.shape[:2], len(shared)))
        return np.concatenate([eta, of_units], axis=-1)


@dataclass(frozen=True)
class Inner(Rows):
    """The mode of the random effects at some parameters.

    `value` (n_clusters,) is log-likelihood minus half the square of `effects` (n_clusters, n_random); `loads` = Z
    Lambda; `at` the expansion of the units there; `precision` (n_clusters, n_random, n_random) the negative Hessian.
    """

    value: Array
    effects: Array
    loads: Array
    points: Array
    at: Expansion
    precision: Array


@dataclass(frozen=True)
class MixedFit:
    """`parameters` at the largest log marginal likelihood, their covariance (zeros in the rows of a scale that is 0),
    the Hessian's smallest eigenvalue over its diagonal, the largest gradient left over, and the inner mode."""

    parameters: Array
    covariance: Array
    log_marginal: float
    flatness: float
    gradient: float
    inner: Inner


def inner_mode(model: ClusteredModel, parameters: Array, start: Array | None = None) -> Inner:
    """Damped Newton steps of all clusters at once, each with its own damping."""
    beta, shared, theta = model.parts(parameters)
    loads, offset = model.random @ model.scale(theta), model.fixed @ beta
    effects = np.zeros((loads.shape[0], loads.shape[-1])) if start is None else start
    damping = np.zeros(len(effects))
    here = _at(model, offset, loads, effects, shared)
    for _ in range(MAX_INNER_STEPS):
        step, decrement = _inner_step(here, damping)
        there = _at(model, offset, loads, here.effects + step, shared)
        # A negative decrement is that of an indefinite Hessian, whose step leads away from a summit.
        rounding = 1e-12 * (1 + np.abs(here.value))
        better = (decrement >= 0) & (there.value >= here.value - rounding)
        more = np.maximum(10 * damping, 1e-2 * _diagonal(here.precision))
        damping = np.where(better, damping / 10, more)
        damping[damping < 1e-8] = 0.0  # only Newton's own step squares the error, and may end the search below
        here = there if better.all() else there.where(better, here)
        near = np.abs(decrement) <= SMALL_INNER_DECREMENT * (1 + np.abs(here.value))
        if (near & (damping == 0)).all() or (damping > 1e14).any():
            break
    return here


def _diagonal(matrix: Array) -> Array:
    return np.asarray(np.abs(np.diagonal(matrix, axis1=1, axis2=2)).max(axis=1))


def _at(model: ClusteredModel, offset: Array, loads: Array, effects: Array, shared: Array) -> Inner:
    points = model.points(offset, loads, effects, shared)
    at, d = model.log_likelihood(points), offset.shape[-1]
    precision = precision_of(loads, -at.hessian[..., :d, :d])
    value = at.value.sum(axis=1) - 0.5 * np.square(effects).sum(axis=1)
    return Inner(value, effects, loads, points, at, precision)


def precision_of(loads: Array, curvature: Array) -> Array:
    """The negative Hessian (n_clusters, n_random, n_random) of the random effects."""
    n_clusters, n_slots, d, n = loads.shape
    bent = np.einsum("csab,csbq->csaq", curvature, loads).reshape(n_clusters, n_slots * d, n)
    return np.asarray(np.eye(n) + np.swapaxes(loads.reshape(bent.shape), 1, 2) @ bent)


def _inner_step(here: Inner, damping: Array) -> tuple[Array, Array]:
    d = here.loads.shape[2]
    gradient = np.einsum("csaq,csa->cq", here.loads, here.at.gradient[..., :d]) - here.effects
    damped = here.precision + damping[:, None, None] * np.eye(gradient.shape[1])
    try:
        step = np.linalg.solve(damped, gradient[..., None])[..., 0]
    except np.linalg.LinAlgError:  # without an inverse: no step is better, all are damped more
        return np.zeros_like(gradient), np.full(len(gradient), -1.0)
    return step, (step * gradient).sum(axis=1)


def log_marginal(model: ClusteredModel, parameters: Array, inner: Inner) -> tuple[float, Array]:
    """Laplace's log marginal likelihood (plus the log prior), and its gradient."""
    d = inner.loads.shape[2]
    bends = [_bend(model, inner, axis) for axis in range(d + model.n_shared)]
    first, hessian = inner.at.gradient[..., :d], inner.at.hessian[..., :d, :d]
    w = model.curvature(inner.points)
    precision = precision_of(inner.loads, w)
    transposed = np.swapaxes(inner.loads, 2, 3)
    spread = np.linalg.solve(precision[:, None], transposed)  # H^-1 A'
    variance = inner.loads @ spread
    # How -log det H / 2 changes along each point, first with the effects held still ...
    drift = -0.5 * np.stack([(variance * bend).sum(axis=(2, 3)) for bend in bends], axis=-1)
    # ... then with the mode, which follows by the observed Hessian also where H is made of expected information.
    along_effects = np.einsum("csqa,csa->cq", transposed, drift[..., :d])
    pull = np.linalg.solve(inner.precision, along_effects[..., None])[..., 0]
    moved = np.einsum("csaq,cq->csa", inner.loads, pull)
    total = first + drift[..., :d] + np.einsum("csab,csb->csa", hessian, moved)
    # Lambda enters thrice: by eta, by the gradient whose zero the mode is, and by H itself.
    # `optimize`: three factors at once would take every combination of all indices.
    by_eta = np.einsum("csaq,csa,cr->qr", model.random, total, inner.effects, optimize=True)
    by_mode = np.einsum("csaq,csa,cr->qr", model.random, first, pull, optimize=True)
    by_determinant = np.einsum("csaq,csab,csrb->qr", model.random, w, spread, optimize=True)
    by_scale = by_eta + by_mode - by_determinant
    by_fixed = np.einsum("csap,csa->p", model.fixed, total)
    directly = (inner.at.gradient + drift)[..., d:].sum(axis=(0, 1))
    by_shared = directly + np.einsum("csa,csap->p", moved, inner.at.hessian[..., :d, d:])
    gradient = np.concatenate([by_fixed, by_shared, np.tensordot(model.basis, by_scale, axes=2)])
    sign, log_determinant = np.linalg.slogdet(precision)
    is_definite = (sign > 0).all()
    value = float((inner.value - 0.5 * log_determinant).sum()) if is_definite else ILL
    return with_prior(model, parameters, value, gradient)


def with_prior(model: ClusteredModel, parameters: Array, value: float, gradient: Array) -> tuple[float, Array]:
    """A log marginal and its gradient, plus those of the log prior; `ILL` for what is no number."""
    n = model.n_fixed + model.n_shared
    if model.log_prior is not None:
        extra, slope = model.log_prior(parameters[:n])
        value = value + extra
        gradient = np.concatenate([gradient[:n] + slope, gradient[n:]])
    return (value if np.isfinite(value) else ILL), gradient


def _bend(model: ClusteredModel, inner: Inner, axis: int) -> Array:
    """The derivative of the curvature of each unit along one of its predictors or shared parameters."""
    step = DIFFERENCE * np.eye(inner.points.shape[-1])[axis]
    up, down = (model.curvature(inner.points + side * step) for side in (1, -1))
    return np.asarray((up - down) / (2 * DIFFERENCE))


Marginal = Callable[[ClusteredModel, Array, Inner], tuple[float, Array]]


class _Objective:
    """The negative of the log marginal; each call starts from the random effects of the one before.

    A search may try parameters so far away that a matrix loses all its digits: they are as impossible as those under
    which the answers have no chance.
    """

    def __init__(self, model: ClusteredModel, marginal: Marginal) -> None:
        self._model, self._marginal = model, marginal
        self.effects: Array | None = None

    def __call__(self, parameters: Array) -> tuple[float, Array]:
        try:
            inner = inner_mode(self._model, parameters, self.effects)
            value, gradient = self._marginal(self._model, parameters, inner)
        except np.linalg.LinAlgError:
            return -ILL, np.zeros(len(parameters))
        if value <= ILL or not np.isfinite(gradient).all():
            return -ILL, np.zeros(len(parameters))
        self.effects = inner.effects
        return -value, -gradient


def maximise(model: ClusteredModel, start: Array, marginal: Marginal = log_marginal) -> MixedFit:
    """Quasi-Newton steps (BFGS, from the start's inverse Hessian), then Newton's, from `start` (n_parameters,).

    `marginal` gives the log marginal likelihood and its gradient at parameters and their inner mode.
    """
    from scipy.optimize import minimize  # slow to load

    objective = _Objective(model, marginal)
    with np.errstate(all="ignore"):
        parameters, hessian = start, _hessian(objective, start)
        for _ in range(MAX_RESTARTS):
            # scipy raises for a matrix that is not definite, and begins at the unit matrix for None.
            inverse, _ = symmetric_inverse(hessian)
            first = inverse if _is_definite(inverse) else None
            options: Any = {"gtol": GRADIENT_TOLERANCE, "hess_inv0": first}
            parameters = minimize(objective, parameters, jac=True, method="BFGS", options=options).x
            parameters, hessian = _newton_steps(objective, parameters)
            value, gradient = objective(parameters)
            if np.abs(gradient).max() < 100 * GRADIENT_TOLERANCE:
                break
        inner = inner_mode(model, parameters, objective.effects)
    covariance, flatness = symmetric_inverse(hessian)
    return MixedFit(parameters, covariance, -value, flatness, float(np.abs(gradient).max()), inner)


def _is_definite(matrix: Array) -> bool:
    """In the digits that the search's own check has."""
    try:
        np.linalg.cholesky(matrix)
    except np.linalg.LinAlgError:
        return False
    return bool(np.isfinite(matrix).all())


def _newton_steps(objective: _Objective, parameters: Array) -> tuple[Array, Array]:
    """Newton's steps as long as they shrink the gradient; the Hessian at the last but one place."""
    value, gradient = objective(parameters)
    for _ in range(MAX_POLISHING):
        hessian = _hessian(objective, parameters)
        trial = parameters - symmetric_inverse(hessian)[0] @ gradient
        new_value, new_gradient = objective(trial)
        is_flatter = np.abs(new_gradient).max() < 0.9 * np.abs(gradient).max()
        if not (is_flatter and new_value <= value + 1e-9):
            break
        parameters, value, gradient = trial, new_value, new_gradient
        if np.abs(gradient).max() < GRADIENT_TOLERANCE:
            break
    return parameters, hessian


def _hessian(objective: _Objective, parameters: Array) -> Array:
    """Central differences of the exact gradient."""
    steps = DIFFERENCE * np.maximum(1.0, np.abs(parameters))
    columns = []
    for step, unit in zip(steps, np.eye(len(parameters)), strict=True):
        _, ahead = objective(parameters + step * unit)
        _, behind = objective(parameters - step * unit)
        columns.append((ahead - behind) / (2 * step))
    matrix = np.array(columns)
    return np.asarray((matrix + matrix.T) / 2)  # differences leave it symmetric but for their error


def symmetric_inverse(hessian: Array) -> tuple[Array, float]:
    """The inverse with each eigenvalue (at a diagonal of 1) by its size, at least `FLATTEST`; and the smallest."""
    scale = np.sqrt(np.maximum(np.abs(np.diagonal(hessian)), FLATTEST))
    values, vectors = np.linalg.eigh(hessian / np.outer(scale, scale))
    sizes = np.maximum(np.abs(values), FLATTEST)
    inverse = (vectors / sizes) @ vectors.T
    inverse = inverse / np.outer(scale, scale)
    return np.asarray((inverse + inverse.T) / 2), float(values.min())


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
        log_weight = np.log(weights[list(places)]).sum()
        terms.append(density + x @ x + log_weight)
        slopes.append(_slope(model, at, effects))
    total = np.logaddexp.reduce(terms, axis=0)
    half_log_det = 0.5 * np.linalg.slogdet(inner.precision)[1]
    value = float((total - half_log_det - 0.5 * n * np.log(np.pi)).sum())
    shares = np.exp(np.array(terms) - total)
    gradient = np.einsum("nc,ncp->p", shares, slopes)
    return with_prior(model, parameters, value, gradient)


def _slope(model: ClusteredModel, at: Expansion, effects: Array) -> Array:
    """The gradient (n_clusters, n_parameters) of the answers' log-likelihood at some random effects."""
    d = model.fixed.shape[2]
    by_eta, by_shared = at.gradient[..., :d], at.gradient[..., d:].sum(axis=1)
    by_fixed = np.einsum("csap,csa->cp", model.fixed, by_eta)
    by_scale = np.einsum("csaq,csa,cr->cqr", model.random, by_eta, effects, optimize=True)
    by_theta = np.einsum("kqr,cqr->ck", model.basis, by_scale)
    return np.concatenate([by_fixed, by_shared, by_theta], axis=1)


def maximise_by_quadrature(model: ClusteredModel, start: MixedFit, n_nodes: int) -> MixedFit:
    """From Laplace's maximum."""
    return maximise(model, start.parameters, partial(log_marginal_by_quadrature, n_nodes=n_nodes))
