"""Posterior distributions of psychometric functions by quadrature on a box that follows the posterior.

Threshold and log width lie on equidistant nodes (the trapezoidal rule converges faster than any power where a
density dies out inside the box), the rates on Gauss-Legendre nodes. The box starts around the mode, grows
where a face still holds density and shrinks where none is left, before the final grid is laid.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from tactometry.analysis.counts import Array, Counts, Which
from tactometry.analysis.likelihood import GUESS, LAPSE, LOG_WIDTH, N_PARAMETERS, THRESHOLD, weighted
from tactometry.analysis.mode import Mode
from tactometry.analysis.prior import Prior, log_prior_axes
from tactometry.psychometric import Shape, log_mixture

NEGLIGIBLE = 14.0
"""A log density this far below the mode's is outside."""
FINAL_NODES = (45, 33)
RATE_NODES = 8
INTERIOR_RATE_NODES = 16
"""A rate whose density dies out above 0 needs more nodes than one that begins at 0."""
SEARCH_NODES = (13, 11, 5, 5)
START_SD = np.array([10.0, 10.0, 6.0, 6.0])
MAX_SEARCHES = 12


@dataclass(frozen=True)
class Marginals:
    """Posterior means (n_sets, 4), with the width itself in place of its logarithm, and central intervals.

    `threshold`, `width`, `lapse`, `guess` have the shape (n_sets, 2); all on the scale of `Counts.u`. The
    quantiles of threshold and width come from the marginal density; those of the rates from its sum over the
    nodes.
    """

    mean: Array
    threshold: Array
    width: Array


@dataclass(frozen=True)
class _Box:
    low: Array
    high: Array

    def __getitem__(self, which: Which) -> "_Box":
        return _Box(self.low[which], self.high[which])


def marginals(shape: Shape, counts: Counts, prior: Prior, mode: Mode, interval: float) -> Marginals:
    """Means and central intervals of every data set, one data set's grid at a time in memory."""
    if not len(counts):
        return Marginals(np.empty((0, N_PARAMETERS)), np.empty((0, 2)), np.empty((0, 2)))
    boxes = _found_box(shape, counts, prior, mode)
    each = [
        _marginals_of_one(shape, counts[i : i + 1], prior[slice(i, i + 1)], boxes[slice(i, i + 1)], interval)
        for i in range(len(counts))
    ]
    return Marginals(*(np.concatenate(parts) for parts in zip(*each, strict=True)))


def _found_box(shape: Shape, counts: Counts, prior: Prior, mode: Mode) -> _Box:
    """The smallest box, up to a node, outside of which the density is negligible."""
    ends = _Box(*prior.bounds())
    sd = np.sqrt(np.maximum(np.diagonal(mode.covariance, axis1=1, axis2=2), 0.0))
    reach = np.where(sd > 0, START_SD * sd, np.inf)
    box = _Box(np.maximum(mode.theta - reach, ends.low), np.minimum(mode.theta + reach, ends.high))
    open_sets = np.arange(len(counts))
    for _ in range(MAX_SEARCHES):
        part = box[open_sets]
        new = _adapted(
            part,
            ends[open_sets],
            _profiles(shape, counts[open_sets], prior[open_sets], part),
            mode.log_density[open_sets],
        )
        moved = (np.abs(new.low - part.low) + np.abs(new.high - part.high)) > 0.2 * (part.high - part.low)
        box.low[open_sets], box.high[open_sets] = new.low, new.high
        open_sets = open_sets[moved.any(axis=1)]
        if not len(open_sets):
            break
    return box


def _profiles(shape: Shape, counts: Counts, prior: Prior, box: _Box) -> list[Array]:
    """Along each parameter, the largest log density over the others on a coarse grid: 4 of (n_sets, n_nodes)."""
    profiles: list[list[Array]] = [[] for _ in range(N_PARAMETERS)]
    for i in range(len(counts)):
        axes = [
            np.linspace(box.low[i, place], box.high[i, place], n if place in prior.free else 1)
            for place, n in enumerate(SEARCH_NODES)
        ]
        density = _log_density_grid(shape, counts[i : i + 1], prior[slice(i, i + 1)], axes)
        for place in range(N_PARAMETERS):
            profiles[place].append(density.max(axis=tuple(j for j in range(N_PARAMETERS) if j != place)))
    return [np.array(profile) for profile in profiles]


def _adapted(box: _Box, ends: _Box, profiles: list[Array], best: Array) -> _Box:
    low, high = box.low.copy(), box.high.copy()
    for place, profile in enumerate(profiles):
        if profile.shape[1] == 1:
            continue
        size = box.high[:, place] - box.low[:, place]
        step = size / (profile.shape[1] - 1)
        inside = profile > np.maximum(best, profile.max(axis=1))[:, None] - NEGLIGIBLE
        first, last = inside.argmax(axis=1), profile.shape[1] - 1 - inside[:, ::-1].argmax(axis=1)
        grown = np.where(first == 0, box.low[:, place] - 0.6 * size, box.low[:, place] + (first - 1) * step)
        low[:, place] = np.maximum(grown, ends.low[:, place])
        grown = np.where(
            last == profile.shape[1] - 1,
            box.high[:, place] + 0.6 * size,
            box.low[:, place] + (last + 1) * step,
        )
        high[:, place] = np.minimum(grown, ends.high[:, place])
    return _Box(low, high)


def _nodes(prior: Prior, low: Array, high: Array) -> tuple[list[Array], list[Array]]:
    """Nodes and weights along each parameter for the box of one data set; one node for a fixed parameter."""
    nodes, weights = [], []
    for place in range(N_PARAMETERS):
        if place not in prior.free:
            unit, weight = np.zeros(1), np.ones(1)
        elif place in (LAPSE, GUESS):
            points, weight = np.polynomial.legendre.leggauss(RATE_NODES if low[place] == 0 else INTERIOR_RATE_NODES)
            unit = (points + 1) / 2
        else:
            unit = np.linspace(0, 1, FINAL_NODES[place])
            weight = np.ones(FINAL_NODES[place])
        nodes.append(low[place] + (high[place] - low[place]) * unit)
        weights.append(weight)
    return nodes, weights


def _log_density_grid(shape: Shape, counts: Counts, prior: Prior, axes: list[Array]) -> Array:
    """Log density on the product of four axes for one data set; shape of the four lengths."""
    used = counts.n_trials[0] > 0
    u, k, n = counts.u[0, used], counts.n_yes[0, used], counts.n_trials[0, used]
    m, v, lapse, guess = axes
    z = shape.z50 + (u[:, None, None] - m[:, None]) * (shape.z_width * np.exp(-v))
    log_cdf, log_sf = (part(z)[..., None, None] for part in (shape.log_cdf, shape.log_sf))
    total = np.zeros((len(m), len(v), len(lapse), len(guess)))
    with np.errstate(divide="ignore"):
        for i in range(len(u)):
            yes, no = _both(log_cdf[i], log_sf[i], guess[None, :], lapse[:, None], k[i], n[i])
            total += weighted(k[i], yes)
            total += weighted(n[i] - k[i], no)
        return total + _log_prior_grid(prior, axes)


def _both(log_cdf: Array, log_sf: Array, guess: Array, lapse: Array, k: float, n: float) -> tuple[Array, Array]:
    """log psi and log(1 - psi) on the grid.

    On its way through the linear scale a chance loses nothing that matters here: it is a sum of positive
    parts, and only where the asymptote is 0 and S underflows is the logarithm needed.
    """
    span = 1 - guess - lapse
    if (k == 0 or guess.min() > 0) and (k == n or lapse.min() > 0):
        yes = np.log(guess + span * np.exp(log_cdf)) if k > 0 else np.zeros(1)
        no = np.log(lapse + span * np.exp(log_sf)) if k < n else np.zeros(1)
        return yes, no
    return log_mixture(log_cdf, log_sf, guess, lapse)


def _log_prior_grid(prior: Prior, axes: list[Array]) -> Array:
    """The prior is a product: its logarithm is a sum along the axes."""
    threshold, log_width, lapse, guess = log_prior_axes(prior, axes)
    return (threshold[:, None] + log_width)[..., None, None] + (lapse[:, None] + guess)


def _marginals_of_one(
    shape: Shape, counts: Counts, prior: Prior, box: _Box, interval: float
) -> tuple[Array, Array, Array]:
    axes, weights = _nodes(prior, box.low[0], box.high[0])
    density = _log_density_grid(shape, counts, prior, axes)
    density += axes[LOG_WIDTH][:, None, None]
    density -= density.max()
    mass = np.exp(density, out=density)
    mass *= weights[LAPSE][:, None] * weights[GUESS]
    along = [mass.sum(axis=tuple(j for j in range(N_PARAMETERS) if j != place)) for place in range(N_PARAMETERS)]
    nodes = [np.exp(axis) if place == LOG_WIDTH else axis for place, axis in enumerate(axes)]
    mean = np.array([(a * x).sum() / a.sum() for a, x in zip(along, nodes, strict=True)])
    ends = np.array([(1 - interval) / 2, (1 + interval) / 2])
    threshold = _quantiles(axes[THRESHOLD], along[THRESHOLD], ends)
    width = np.exp(_quantiles(axes[LOG_WIDTH], along[LOG_WIDTH], ends))
    return mean[None], threshold[None], width[None]


def _quantiles(nodes: Array, density: Array, ends: Array) -> Array:
    """Quantiles of a density on equidistant nodes, by the integral of its cubic spline."""
    fine = np.linspace(nodes[0], nodes[-1], 40 * len(nodes))
    cumulated = np.maximum.accumulate(CubicSpline(nodes, density).antiderivative()(fine))
    return np.asarray(np.interp(ends * cumulated[-1], cumulated, fine))


__all__ = ["Marginals", "marginals"]
