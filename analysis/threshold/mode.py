"""Modes of many posteriors (or likelihoods) at once.

Damped Newton steps with the exact Hessian start from every local maximum of a coarse grid. The damping is scaled by the
diagonal. Steps are projected onto the bounds, as lapse and guess rates often lie on a bound.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Array, Bools, Expansion, Rows, symmetric_inverse
from .likelihood import LOG_WIDTH, N_PARAMETERS, THRESHOLD
from .log_posterior import LARGEST_ETA, LogPosterior, log_prior_of
from .start_values import Starts, grid_starts, step_starts

MAX_STEPS = 80
ROUGH_DECREMENT = 1e-3
"""Decrement at which the starts of a set are compared; starts that lead to the same maximum agree by then."""
APART = np.array([0.02, 0.05, 0.01, 0.01])
"""Smallest differences between distinct maxima: threshold and log width in ranges of the levels, and rates."""
MOST_TO_GAIN = 0.5
"""Largest gain in log density that a start may still make after the comparison."""
SMALL_DECREMENT = 1e-13
ROUNDING = 1e-14
"""Relative rounding error of a log density, which may hide that a step near the maximum goes up."""
ENDLESS_GAIN, ENDLESS_STEP = 1e-7, 1e-3
"""A log width that moves this far for this little gain has no maximum: the likelihood of separated answers rises with
steepness without limit."""
WORTH_LEAVING = 0.6
EQUAL = 1e-9
POOR_FIT = 2.0
"""Ratio of deviance to degrees of freedom above which a fit is poor."""
STEP_MARGIN = 1.0
"""Log density below the mode from which a start at a step may still end above it."""
SMALLEST_CURVATURE = 1e-12
COARSE = (0.0, 0.03, 0.06, 0.1, 0.15, 0.22, 0.32, 0.45, 0.65)
"""Overdispersions at which the search begins; `N_GOLDEN` golden sections then refine the best one."""
GOLDEN = (np.sqrt(5) - 1) / 2
N_GOLDEN = 16


@dataclass(frozen=True)
class Mode(Rows):
    """Parameters (n_sets, 4) at the maximum, and Laplace's covariance.

    The covariance has zeros for a parameter that is fixed or lies on its bound. `interior` is False if threshold or
    width lie on a bound; there is then no mode.
    """

    theta: Array
    log_density: Array
    covariance: Array
    interior: Bools

    @property
    def sd(self) -> Array:
        return np.sqrt(np.diagonal(self.covariance, axis1=1, axis2=2))


def find_mode(posterior: LogPosterior, near: Array | None = None) -> Mode:
    """Find modes, starting from a grid or `near` (n_sets, 4), then steps.

    If a fit is poor, the best nodes of narrow and wide widths are starts too.
    """
    if near is None:
        summits, _ = grid_starts(posterior)
        mode = _highest(posterior, summits)
    else:
        mode = climb(posterior, near)
    again = _second_starts(posterior, mode)
    return _highest(posterior, again, mode) if len(again.sets) else mode


def _second_starts(posterior: LogPosterior, mode: Mode) -> Starts:
    if posterior.prior.overdispersion is not None:
        return Starts.none()
    df = np.maximum(posterior.counts.n_levels - len(posterior.prior.free), 1)
    poor = np.flatnonzero(posterior.deviance(mode.theta) > POOR_FIT * df)
    _, halves = grid_starts(posterior[poor])
    steps = step_starts(posterior, mode.log_density - STEP_MARGIN)
    return Starts(poor[halves.sets], halves.theta).joined(steps)


def _highest(posterior: LogPosterior, starts: Starts, known: Mode | None = None) -> Mode:
    """Return the highest mode of each set from `starts` and `known`."""
    n_sets = len(posterior)
    starts = _distinct(starts, *_ascend(posterior[starts.sets], starts.theta, ROUGH_DECREMENT))
    sets = starts.sets
    modes = climb(posterior[sets], starts.theta)
    if known is not None:
        modes = known.joined(modes)
        sets = np.concatenate([np.arange(n_sets), sets])
    highest = np.full(n_sets, -np.inf)
    np.maximum.at(highest, sets, modes.log_density)
    equal = np.flatnonzero(modes.log_density >= highest[sets] - EQUAL)
    _, first = np.unique(sets[equal], return_index=True)
    return modes[equal[first]]


def _distinct(starts: Starts, theta: Array, log_density: Array) -> Starts:
    """Keep the highest maximum of each set, and possible rivals."""
    order = np.lexsort((-log_density, starts.sets))
    sets, theta, log_density = starts.sets[order], theta[order], log_density[order]
    _, first, inverse = np.unique(sets, return_index=True, return_inverse=True)
    best = first[inverse]
    is_apart = (np.abs(theta - theta[best]) > APART).any(axis=1)
    kept = is_apart & (log_density > log_density[best] - MOST_TO_GAIN)
    kept[first] = True
    return Starts(sets[kept], theta[kept])


def climb(posterior: LogPosterior, start: Array, *, small_decrement: float = SMALL_DECREMENT) -> Mode:
    """Climb from `start` (n_sets, 4) until a step gains `small_decrement`."""
    return _laplace(posterior, _ascend(posterior, start, small_decrement)[0])


def _ascend(posterior: LogPosterior, start: Array, small_decrement: float) -> tuple[Array, Array]:
    """Return the parameters and log densities reached from `start`."""
    low, high = posterior.prior.bounds()
    theta = posterior.prior.tied(np.clip(start, low, high))
    log_density = np.empty(len(posterior))
    # `sets` contains all sets that still climb; finished sets are removed only in large numbers.
    sets, climbing = np.arange(len(posterior)), posterior.by_level()
    at, here, damping = theta.copy(), climbing.expansion(theta), np.full(len(posterior), 1e-3)
    for _ in range(MAX_STEPS):
        step, decrement = _step(here, _is_held(at, here.gradient, low, high), damping)
        trial = posterior.prior.tied(np.clip(at + step, low, high))
        there = climbing.expansion(trial)
        better = there.value >= here.value - ROUNDING * np.abs(here.value)
        at = np.where(better[:, None], trial, at)
        here = there.where(better, here)
        damping = np.where(better, np.maximum(damping / 10, 1e-12), damping * 8)
        is_endless = (decrement < ENDLESS_GAIN) & (np.abs(step[:, LOG_WIDTH]) > ENDLESS_STEP)
        small = small_decrement * np.maximum(1.0, np.abs(here.value))
        going = (decrement > small) & ~is_endless & (damping < 1e15)  # with more damping, steps are below rounding
        theta[sets], log_density[sets] = at, here.value
        if not going.any():
            break
        if going.mean() < WORTH_LEAVING:
            sets, at, here, damping = sets[going], at[going], here[going], damping[going]
            climbing = climbing[going].by_level()  # restore the memory layout after indexing
            low, high = climbing.prior.bounds()
    return theta, log_density


def _is_held(theta: Array, gradient: Array, low: Array, high: Array) -> Bools:
    """Return True for parameters that are fixed or kept at a bound."""
    at_low = (theta <= low) & (gradient <= 0)
    at_high = (theta >= high) & (gradient >= 0)
    return np.asarray((low == high) | at_low | at_high)


def _step(here: Expansion, held: Bools, damping: Array) -> tuple[Array, Array]:
    """Return the damped Newton step of free parameters, and its decrement."""
    gradient = np.where(held, 0.0, here.gradient)
    step = convex_solve(_without(-here.hessian, held), gradient, damping)
    return step, (step * gradient).sum(axis=1)


def convex_solve(matrix: Array, right: Array, damping: Array) -> Array:
    """Solve n linear systems (n, p, p), made positive definite.

    Systems are scaled to a diagonal of 1. Each pivot of the square-root-free Cholesky factorisation is replaced by its
    absolute value, at least 1e-8, plus the damping (n,). The solutions have the shape (n, p).

    The computation is vectorised over systems, unlike LAPACK's eigenvalues (Gill, Murray and Wright, Practical
    Optimization, 1981, section 4.4.2).

    >>> convex_solve(np.array([[[4.0, 2.0], [2.0, 2.0]]]), np.array([[2.0, 2.0]]), np.zeros(1)).round(12) + 0
    array([[0., 1.]])
    """
    p = right.shape[1]
    diagonal = np.abs(np.diagonal(matrix, axis1=1, axis2=2))
    scale = np.sqrt(diagonal + SMALLEST_CURVATURE).T
    # Put the systems on the last axis, so that each step below operates on contiguous memory.
    a = np.ascontiguousarray(np.moveaxis(matrix, 0, 2)) / (scale[:, None] * scale)
    x = [right[:, i] / scale[i] for i in range(p)]
    pivots = []
    for j in range(p):
        pivots.append(np.maximum(np.abs(a[j][j]), 1e-8) + damping)
        for i in range(j + 1, p):
            factor = a[j][i] / pivots[j]
            x[i] = x[i] - factor * x[j]
            for k in range(i, p):
                a[i][k] = a[i][k] - factor * a[j][k]
    for j in reversed(range(p)):
        solved = sum(a[j][k] * x[k] for k in range(j + 1, p))
        x[j] = (x[j] - solved) / pivots[j]
    return np.stack([x[i] / scale[i] for i in range(p)], axis=1)


def _without(matrix: Array, held: Bools) -> Array:
    """Replace rows and columns of held parameters by the identity."""
    either = held[:, :, None] | held[:, None, :]
    finite = np.where(np.isfinite(matrix), matrix, np.nan)
    return np.where(either, np.eye(N_PARAMETERS), finite)


def _laplace(posterior: LogPosterior, theta: Array) -> Mode:
    here = posterior.expansion(theta)
    low, high = posterior.prior.bounds()
    # Ignore the curvature at a bound, whatever the direction in which the density rises.
    held = _is_held(theta, here.gradient, low, high) | (theta <= low) | (theta >= high)
    curvature = _without(-here.hessian, held)
    is_finite = np.isfinite(curvature).all(axis=(1, 2), keepdims=True)
    inverse = np.where(is_finite, symmetric_inverse(np.where(is_finite, curvature, np.eye(N_PARAMETERS))), np.nan)
    covariance = np.where(held[:, :, None] | held[:, None, :], 0.0, inverse)
    on_bound = held[:, [THRESHOLD, LOG_WIDTH]].any(axis=1)
    return Mode(theta, here.value, covariance, np.asarray(~on_bound))


def find_overdispersed_mode(posterior: LogPosterior) -> tuple[Mode, Array]:
    """Return the mode and eta, by a grid and golden-section search over eta."""
    nodes, near = np.array(COARSE), find_mode(posterior).theta

    def at(eta: Array) -> Mode:
        overdispersed = posterior.under(overdispersion=eta)
        by_grid, by_binomial = find_mode(overdispersed), find_mode(overdispersed, near)
        highest = by_binomial.where(by_binomial.log_density > by_grid.log_density, by_grid)
        return replace(highest, log_density=highest.log_density + log_prior_of(eta))

    densities = np.stack([at(np.full(len(posterior), eta)).log_density for eta in nodes], axis=1)
    best = densities.argmax(axis=1)
    low, high = nodes[np.maximum(best - 1, 0)], np.append(nodes, LARGEST_ETA)[best + 1]
    for _ in range(N_GOLDEN):
        reach = GOLDEN * (high - low)
        left, right = high - reach, low + reach
        to_left = at(left).log_density >= at(right).log_density
        low, high = np.where(to_left, low, left), np.where(to_left, right, high)
    eta = (low + high) / 2
    # Golden sections never reach eta = 0 (the binomial), so it is compared explicitly.
    is_binomial = at(np.zeros(len(posterior))).log_density >= at(eta).log_density
    eta = np.where(is_binomial, 0.0, eta)
    return at(eta), eta
