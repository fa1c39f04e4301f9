"""Importance sampling of the posterior of the hyperparameters.

Laplace's approximation integrates out means and effects at each point, as in INLA (Rue, Martino and Chopin 2009,
J. R. Stat. Soc. B 71, 319-392). Participants share only the means, so the negative Hessian of the log density is
bordered. The effects of each participant are eliminated first (Schur complement), then the means are solved for.

The points are fixed, from an additive recurrence (a quasi-random sequence). The first round transforms them to a
Student's t distribution at the mode, later rounds to one with the moments found so far. All rounds are weighted
jointly.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import gammaincinv, ndtr, ndtri

from ..arrays import Array, Expansion, Rows, symmetric_inverse
from .model import GroupModel

MAX_STEPS = 60
SMALL_DECREMENT = 1e-9
"""Decrement below which the search may end, as the next Newton step would square it."""
FIRST_DAMPING, SMALLEST_DAMPING = 1e-2, 1e-4
"""The search may end only with less damping than this, as damped steps converge slowly."""
N_POINTS = 256
"""Number of points of a round; the first round, at the mode, has half as many."""
ENOUGH, MAX_ROUNDS = 0.15, 5
"""Rounds are added until the effective points reach this fraction of a round, or up to this number of rounds."""
FEWEST_EFFECTIVE = 5.0
DF = 5.0
"""Degrees of freedom of the Student's t distribution."""
STEP = 0.05
GRADIENT_STEP = 1e-3
UNITS_AT_ONCE = 100_000
"""Number of levels of cells that are computed at once (about 50 MB)."""
GOLDEN_ROUNDS = 40
FARTHEST, BISECTIONS = 10.0, 50
SMALLEST_SD = 1e-12


@dataclass(frozen=True)
class InnerMode(Rows):
    """Mode of means and effects, one row per point of the hyperparameters.

    `value` (n,) is the log density. `means` has the shape (n, n_fixed), `effects` (n, n_participants, n_random).
    `points` are the predictors of all cells and `at` their log-likelihoods.
    """

    value: Array
    means: Array
    effects: Array
    points: Array
    at: Expansion


@dataclass(frozen=True)
class Bordered:
    """Negative Hessian of means and effects, in blocks.

    `local` (n, n_participants, q, q) is the block of effects, `cross` (n, n_participants, q, p) that of effects and
    means, and `pulled` is the inverse of `local` times `cross`. `schur` (n, p, p) is the Schur complement of the means,
    to which each participant contributes `own`.
    """

    local: Array
    cross: Array
    pulled: Array
    own: Array
    schur: Array

    @property
    def half_log_determinant(self) -> Array:
        """Half the log determinant (n,), infinite if not positive definite."""
        signs, logs = np.linalg.slogdet(self.local)
        sign, log = np.linalg.slogdet(self.schur)
        is_definite = (signs > 0).all(axis=1) & (sign > 0)
        return np.where(is_definite, 0.5 * (logs.sum(axis=1) + log), np.inf)


def find_inner(model: GroupModel, hyper: Array, means: Array, effects: Array) -> InnerMode:
    """Find the mode of means and effects by damped Newton steps."""
    precision, n = model.precision(hyper)[0], len(hyper)
    start = np.broadcast_to(means, (n, means.shape[-1])), np.broadcast_to(effects, (n, *effects.shape[-2:]))
    result = inner_at(model, hyper, precision, *start)
    damping, left, here = np.zeros(n), np.arange(n), result
    for _ in range(MAX_STEPS):
        *steps, decrement = _step(model, here, precision[left], damping)
        there = inner_at(model, hyper[left], precision[left], here.means + steps[0], here.effects + steps[1])
        rounding = 1e-12 * (1 + np.abs(here.value))
        better = (decrement >= 0) & (there.value >= here.value - rounding)
        here = there.where(better, here)
        result = result.replaced(left, here)
        is_near = (np.abs(decrement) <= SMALL_DECREMENT * (1 + np.abs(here.value))) & (damping < SMALLEST_DAMPING)
        damping = np.where(better, damping / 10, np.maximum(10 * damping, FIRST_DAMPING))
        going = ~(is_near | (damping > 1e10))
        left, damping, here = left[going], damping[going], here[going]
        if not len(left):
            break
    return result


def inner_at(model: GroupModel, hyper: Array, precision: Array, means: Array, effects: Array) -> InnerMode:
    """Return the log density at means and effects."""
    offset = model.offsets(hyper)[:, None] + np.einsum("cdp,np->ncd", model.fixed, means)
    points = offset[:, None] + np.einsum("cdq,niq->nicd", model.random, effects)
    at = model.log_likelihood(points, hyper)
    mean, by_mean = (part[: means.shape[1]] for part in model.means_prior)
    bound = 0.5 * np.einsum("niq,nqr,nir->n", effects, precision, effects, optimize=True)
    bound = bound + 0.5 * np.square(means - mean) @ by_mean
    value = at.value.sum(axis=(1, 2)) - bound
    return InnerMode(np.where(np.isfinite(value), value, -np.inf), means, effects, points, at)


def bordered(model: GroupModel, curvature: Array, precision: Array, damping: Array | float = 0.0) -> Bordered:
    """Return the negative Hessian from the curvature of the cells."""
    x, z = model.fixed, model.random
    c, d, q = z.shape
    n, n_people = curvature.shape[:2]
    bent_z = (curvature @ z).reshape(n, n_people, c * d, q)
    bent_x = (curvature @ x).reshape(n, n_people, c * d, -1)
    z_all, x_all = z.reshape(c * d, q).T, x.reshape(c * d, -1).T
    more = np.broadcast_to(np.asarray(damping), (n,))[:, None, None]
    # Damp in proportion to the priors' curvature, as effects have different scales.
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


@dataclass(frozen=True)
class Conditional(Rows):
    """Laplace's approximation at given hyperparameters.

    `log_density` (n,) is the log density of the hyperparameters. `covariance` belongs to `means` (n, n_fixed),
    `variances` to the predictors `cells` (n, n_participants, n_conditions, 2).
    """

    hyper: Array
    log_density: Array
    means: Array
    covariance: Array
    cells: Array
    variances: Array
    effects: Array


@dataclass(frozen=True)
class Integrated:
    """Points of the integral, with weights that sum to 1."""

    at: Conditional
    weights: Array

    @property
    def n_effective(self) -> float:
        return _n_effective(self.weights)

    def mean(self, values: Array) -> Array:
        return np.asarray(np.tensordot(self.weights, values, axes=1))


class Laplace:
    """Log posterior of hyperparameters by Laplace's approximation.

    Each call starts from the means and effects at the best point so far.
    """

    def __init__(self, model: GroupModel, hyper: Array, means: Array) -> None:
        n = model.study.n_participants
        self.model, self.means, self.effects = model, means, np.zeros((n, model.random.shape[2]))
        result = self(hyper[None])
        self.move(result)

    def move(self, found: "Conditional") -> None:
        best = int(np.argmax(found.log_density))
        self.means, self.effects = found.means[best], found.effects[best]

    def __call__(self, hyper: Array) -> Conditional:
        n_at_once = max(1, UNITS_AT_ONCE // self.model.counts.u.size)
        parts = [self._some(hyper[i : i + n_at_once]) for i in range(0, len(hyper), n_at_once)]
        whole = parts[0]
        for part in parts[1:]:
            whole = whole.joined(part)
        return whole

    def _some(self, hyper: Array) -> Conditional:
        model = self.model
        with np.errstate(all="ignore"):
            inner = find_inner(model, hyper, self.means, self.effects)
            precision, half = model.precision(hyper)
            hessian = bordered(model, model.information(inner.points, hyper), precision)
            n = model.study.n_participants
            value = inner.value + n * half - hessian.half_log_determinant + model.log_prior(hyper)
            covariance = np.asarray(np.linalg.inv(hessian.schur), dtype=np.float64)
            z, x = model.random[:, :2], model.fixed[:, :2]
            spread = np.linalg.solve(hessian.local[:, :, None], np.swapaxes(z, 1, 2))
            inside = np.einsum("cdq,nicqd->nicd", z, spread)
            along = x - np.einsum("cdq,niqp->nicdp", z, hessian.pulled)
            brought = np.einsum("nicdp,npr,nicdr->nicd", along, covariance, along, optimize=True)
        value = np.where(np.isfinite(value), value, -np.inf)
        cells = inner.points[..., :2]
        return Conditional(hyper, value, inner.means, covariance, cells, inside + brought, inner.effects)


def find_mode(laplace: Laplace, hyper: Array) -> tuple[Array, Array]:
    """Return the mode of the hyperparameters and the covariance at the mode."""
    from scipy.optimize import minimize  # slow to load

    k = len(hyper)
    around = np.concatenate([np.zeros((1, k)), GRADIENT_STEP * np.eye(k), -GRADIENT_STEP * np.eye(k)])

    def negative(at: Array) -> tuple[float, Array]:
        result = laplace(at + around)
        values = result.log_density
        if not np.isfinite(values).all():
            return 1e12, np.zeros(k)
        laplace.means, laplace.effects = result.means[0], result.effects[0]
        return -values[0], -(values[1 : k + 1] - values[k + 1 :]) / (2 * GRADIENT_STEP)

    mode = minimize(negative, hyper, jac=True, method="BFGS", options={"gtol": 1e-2, "maxiter": 100}).x
    pairs = [(i, j) for i in range(k) for j in range(i)]
    unit = 2 * STEP * np.eye(k)
    first = [mode + side * unit[i] for side in (1, -1) for i in range(k)]
    second = [mode + a * unit[i] + b * unit[j] for a, b in ((1, 1), (1, -1), (-1, 1), (-1, -1)) for i, j in pairs]
    values = laplace(np.array([mode, *first, *second])).log_density
    here, up, down = values[0], values[1 : k + 1], values[k + 1 : 2 * k + 1]
    crossed = values[2 * k + 1 :].reshape(4, -1)
    hessian = np.diag((up + down - 2 * here) / (2 * STEP) ** 2)
    mixed = (crossed[0] - crossed[1] - crossed[2] + crossed[3]) / (4 * (2 * STEP) ** 2)
    for (i, j), value in zip(pairs, mixed, strict=True):
        hessian[i, j] = hessian[j, i] = value
    return mode, symmetric_inverse(-np.nan_to_num(hessian))


def sequence(n: int, k: int) -> Array:
    """Return n quasi-random points in the k-dimensional unit cube.

    The sequence is an additive recurrence (Roberts 2018).

    >>> sequence(2, 1).round(3).tolist()
    [[0.118], [0.736]]
    """
    root = 2.0
    for _ in range(GOLDEN_ROUNDS):
        root = (1 + root) ** (1 / (k + 1))
    return np.asarray((0.5 + np.arange(1, n + 1)[:, None] * root ** -np.arange(1, k + 1)) % 1)


def _student(n: int, mode: Array, covariance: Array) -> Array:
    """Transform points in the unit cube to a multivariate Student's t."""
    u = sequence(n, len(mode) + 1)
    shrink = np.sqrt(gammaincinv(DF / 2, u[:, -1]) / (DF / 2))
    return np.asarray(mode + ndtri(u[:, :-1]) / shrink[:, None] @ np.linalg.cholesky(covariance).T)


def _log_student(x: Array, mode: Array, covariance: Array) -> Array:
    root = np.linalg.cholesky(covariance)
    away = np.linalg.solve(root, (x - mode).T)
    k = len(mode)
    return np.asarray(-np.log(np.diagonal(root)).sum() - 0.5 * (DF + k) * np.log1p(np.square(away).sum(axis=0) / DF))


def integrate(laplace: Laplace, hyper: Array, n_points: int = N_POINTS) -> Integrated:
    """Integrate over the hyperparameters; return points and weights.

    Raises `LinAlgError` with fewer than `FEWEST_EFFECTIVE` effective points.
    """
    proposals, sizes = [find_mode(laplace, hyper)], [max(1, n_points // 2)]
    at = laplace(_student(sizes[0], *proposals[0]))
    weights = _weights(at, proposals, sizes)
    while len(sizes) < 2 or (_n_effective(weights) < ENOUGH * n_points and len(sizes) < MAX_ROUNDS):
        laplace.move(at)
        proposals.append(_moments(at.hyper, weights, proposals[0][1]))
        sizes.append(n_points)
        at = at.joined(laplace(_student(n_points, *proposals[-1])))
        weights = _weights(at, proposals, sizes)
    if _n_effective(weights) < FEWEST_EFFECTIVE:
        raise np.linalg.LinAlgError("too few effective points")
    return Integrated(at, weights)


def _n_effective(weights: Array) -> float:
    return float(1 / np.square(weights).sum())


def _weights(at: Conditional, proposals: list[tuple[Array, Array]], sizes: list[int]) -> Array:
    shares = [np.log(n) + _log_student(at.hyper, *one) for n, one in zip(sizes, proposals, strict=True)]
    log_weights = at.log_density - np.logaddexp.reduce(shares, axis=0)
    if not np.isfinite(log_weights.max()):
        raise np.linalg.LinAlgError("no point has a positive density")
    weights = np.exp(log_weights - log_weights.max())
    return np.asarray(weights / weights.sum())


def _moments(x: Array, weights: Array, before: Array) -> tuple[Array, Array]:
    """Return weighted moments, shrunk towards `before` if uncertain."""
    mean = weights @ x
    away = x - mean
    n = 1 / np.square(weights).sum()
    share = n / (n + 2 * x.shape[1])
    return mean, share * (away.T * weights) @ away + (1 - share) * before


def quantiles(weights: Array, means: Array, sds: Array, share: float) -> Array:
    """Return quantiles of mixtures of normals (n_points, ...) by bisection."""
    low, high = (means + side * FARTHEST * sds for side in (-1, 1))
    low, high = low.min(axis=0), high.max(axis=0)
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        is_below = np.tensordot(weights, normal_chances(means - middle, sds), axes=1) < share
        low, high = np.where(is_below, middle, low), np.where(is_below, high, middle)
    return np.asarray((low + high) / 2)


def normal_chances(means: Array, sds: Array) -> Array:
    """Return the probabilities that normal values are below 0."""
    return np.asarray(ndtr(-means / np.maximum(sds, SMALLEST_SD)))
