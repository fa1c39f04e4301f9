"""Posteriors of many data sets on one shared grid.

Data sets with the same levels share their nodes, so that matrix products evaluate all of them.

The grid covers the density of every data set, in steps of `STEP_SD` times a typical standard deviation. Posteriors that
are too narrow have a separate grid (`posterior.marginals`). Compared with grids of four times as many nodes, means and
standard deviations differ by at most 0.2 % of the standard deviation, ends of intervals by 0.1 % of their width.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..arrays import Array, Bools
from .likelihood import GUESS, LAPSE, LOG_WIDTH, N_PARAMETERS, THRESHOLD, linear
from .log_posterior import LogPosterior, Prior
from .mode import Mode
from .posterior import NEGLIGIBLE, Marginals, marginals, others, quantiles, rate_rule

MOST_FREE = 3
"""Largest number of free parameters for a shared grid; with two free rates separate grids are faster."""
WORTH_SHARING = 8
"""Smallest number of data sets for a shared grid."""
SEARCH_NODES = (41, 21, 6, 6)
MODE_SD = 6.0
"""The grid extends at least this many standard deviations beyond each mode."""
RATE_NODES = 12
STEP_SD = 0.5
TYPICAL = 0.1
"""Quantile of the standard deviations that determines the step."""
FEWEST_NODES, MOST_NODES = 25, (161, 61)
RESOLVED_STEPS = 1.5
"""Fewest grid steps per standard deviation for a posterior to be resolved."""
RESOLVED_RATE = 0.02
"""Smallest standard deviation of a resolved rate, as a fraction of its range."""
CHUNK = 4_000_000
"""Largest number of nodes times data sets at once (16 MB in single precision)."""


@dataclass(frozen=True)
class Grid:
    """Nodes and log weights along each parameter, and log cell volume."""

    nodes: list[Array]
    log_weights: list[Array]
    log_cell: float

    @property
    def sizes(self) -> tuple[int, ...]:
        return tuple(len(axis) for axis in self.nodes)


def batched_marginals(posterior: LogPosterior, mode: Mode, interval: float) -> Marginals:
    """Integrate like `posterior.marginals`, but on shared grids."""
    all_sets, is_alone = Marginals.empty(len(posterior)), np.ones(len(posterior), dtype=bool)
    if posterior.prior.overdispersion is None and len(posterior.prior.free) <= MOST_FREE:
        for members in posterior.alike():
            if len(members) >= WORTH_SHARING:
                shared, resolved = _marginals_on_grid(posterior[members], mode[members], interval)
                all_sets = all_sets.replaced(members[resolved], shared[resolved])
                is_alone[members[resolved]] = False
    alone = np.flatnonzero(is_alone)
    return all_sets.replaced(alone, marginals(posterior[alone], mode[alone], interval))


def _marginals_on_grid(posterior: LogPosterior, mode: Mode, interval: float) -> tuple[Marginals, Bools]:
    """Return marginals, and True for each data set that the grid resolves."""
    grid, prior = common_grid(posterior, mode), posterior.prior
    along, log_total, beyond = marginal_masses(posterior, grid)
    m, v, lapse, guess = grid.nodes
    threshold = quantiles(along[THRESHOLD], m[:1], m[-1:], interval)
    width = np.exp(quantiles(along[LOG_WIDTH], v[:1], v[-1:], interval))
    values = zip(along, (m, np.exp(v), lapse, guess), strict=True)
    means = [(mass @ x) / mass.sum(axis=1) for mass, x in values]
    mean = prior.tied(np.stack(means, axis=1))
    log_evidence = log_total - prior.log_mass()
    no_box = np.full(mean.shape, np.nan)
    shared = Marginals(mean, threshold, width, np.zeros(len(mean)), log_evidence, beyond, no_box, no_box)
    resolved = np.ones(len(along[0]), dtype=bool)
    for place in prior.free:
        nodes, is_rate = grid.nodes[place], place in (LAPSE, GUESS)
        finest = RESOLVED_RATE * nodes[-1] if is_rate else RESOLVED_STEPS * (nodes[1] - nodes[0])
        resolved &= _spread(along[place], nodes) > finest
    return shared, resolved


def common_grid(posterior: LogPosterior, mode: Mode) -> Grid:
    prior = posterior.prior
    low, high = (end[0] for end in prior.bounds())
    for _ in range(2):  # the first search covers the priors, the second the range found by the first
        axes = prior.search_axes(low, high, SEARCH_NODES)
        low, high = _ends(posterior, mode, Grid(axes, [np.zeros(len(axis)) for axis in axes], 0.0))
    sizes, sd = [], mode.sd
    for place, most in zip((THRESHOLD, LOG_WIDTH), MOST_NODES, strict=True):
        known = sd[sd[:, place] > 0, place]  # a mode on a bound has no SD
        typical = float(np.quantile(known, TYPICAL)) if len(known) else 1.0
        n_steps = (high - low)[place] / (STEP_SD * typical)
        sizes.append(int(np.clip(n_steps, FEWEST_NODES, most)))
    return _final_grid(prior, low, high, sizes)


def _final_grid(prior: Prior, low: Array, high: Array, sizes: list[int]) -> Grid:
    nodes = [np.linspace(low[place], high[place], n) for place, n in enumerate(sizes)]
    log_weights = [np.zeros(sizes[0]), nodes[LOG_WIDTH]]  # convert to the density of the width
    for place in (LAPSE, GUESS):
        unit, weight = rate_rule(RATE_NODES) if place in prior.free else (np.zeros(1), np.ones(1))
        nodes.append(low[place] + (high[place] - low[place]) * unit)
        log_weights.append(np.log(weight))
    return Grid(nodes, log_weights, prior.log_cell(low, high, sizes))


def _tables(posterior: LogPosterior, grid: Grid) -> tuple[Array, Array]:
    """Return log psi and log(1 - psi) by level and node, and the log prior."""
    prior = posterior.prior
    cdf, sf, _ = linear(posterior.shape, posterior.z_of(grid.nodes))
    lapse, guess = grid.nodes[LAPSE], prior.guess_nodes(grid.nodes[LAPSE], grid.nodes[GUESS])
    span = 1 - guess - lapse[:, None]
    with np.errstate(divide="ignore"):
        yes = np.log(guess + span * cdf[..., None, None])
        no = np.log(lapse[:, None] + span * sf[..., None, None])
        along = zip(prior[:1].along(grid.nodes), grid.log_weights, strict=True)
        m, v, lapse, guess = (log_density + log_weight for log_density, log_weight in along)
    outside = (m[:, None] + v)[..., None, None] + (lapse[:, None] + guess)
    table = np.concatenate([yes.reshape(len(cdf), -1), no.reshape(len(cdf), -1)])
    # avoid NaN from 0 * -inf
    return np.maximum(table, -1e6), np.maximum(outside, -1e9).ravel()


def _densities(posterior: LogPosterior, grid: Grid) -> Iterator[tuple[slice, Array]]:
    """Yield a slice of data sets and their log densities (n_sets, n_nodes)."""
    table, outside = _tables(posterior, grid)
    counts = posterior.counts
    used = counts.n_trials[0] > 0
    answers = np.hstack([counts.n_yes[:, used], (counts.n_trials - counts.n_yes)[:, used]])
    size = max(1, CHUNK // len(outside))
    for start in range(0, len(posterior), size):
        sets = slice(start, start + size)
        yield sets, answers[sets] @ table + outside


def _ends(posterior: LogPosterior, mode: Mode, grid: Grid) -> tuple[Array, Array]:
    """Return the ends of nodes with density, with a margin of one node."""
    kept = np.zeros(np.prod(grid.sizes), dtype=bool)
    for sets, density in _densities(posterior, grid):
        best = np.maximum(density.max(axis=1), mode.log_density[sets])
        kept |= (density > best[:, None] - NEGLIGIBLE).any(axis=0)
    inside = kept.reshape(grid.sizes)
    # Also use mode and curvature, as coarse nodes may miss a narrow posterior.
    around = MODE_SD * mode.sd
    low, high = (mode.theta - around).min(axis=0), (mode.theta + around).max(axis=0)
    for place, nodes in enumerate(grid.nodes):
        along = np.flatnonzero(inside.any(axis=others(place)))
        first, last = 0, -1  # keep the whole axis if no node has density
        if len(along):
            first, last = max(along[0] - 1, 0), min(along[-1] + 1, len(nodes) - 1)
        low[place] = max(min(low[place], nodes[first]), nodes[0])
        high[place] = min(max(high[place], nodes[last]), nodes[-1])
    return low, high


def marginal_masses(posterior: LogPosterior, grid: Grid) -> tuple[list[Array], Array, Array]:
    """Return masses (n_sets, n_nodes), log integrals and shares beyond."""
    n_m, n_v, n_lapse, n_guess = grid.sizes
    n_curves, n_rates = n_m * n_v, n_lapse * n_guess
    beyond = posterior.beyond_levels(grid.nodes).reshape(2, -1).T
    chunks = []
    for _, density in _densities(posterior, grid):
        highest = density.max(axis=1, keepdims=True)
        below_highest = (density - highest).astype(np.float32)
        mass = np.exp(below_highest).reshape(len(density), n_curves, n_rates)
        flat = mass @ np.ones(n_rates, dtype=np.float32)
        rates = mass.sum(axis=1).reshape(-1, n_lapse, n_guess)
        curve = flat.reshape(-1, n_m, n_v)
        total = flat.sum(axis=1, dtype=np.float64)
        along = (curve.sum(axis=2), curve.sum(axis=1), rates.sum(axis=2), rates.sum(axis=1))
        log_total = highest[:, 0] + np.log(total) + grid.log_cell
        chunks.append((*along, log_total, flat @ beyond / total[:, None]))
    columns = [np.concatenate(column).astype(np.float64) for column in zip(*chunks, strict=True)]
    return columns[:N_PARAMETERS], columns[-2], columns[-1]


def _spread(mass: Array, nodes: Array) -> Array:
    share = mass / mass.sum(axis=1, keepdims=True)
    mean = share @ nodes
    variance = (share * np.square(nodes - mean[:, None])).sum(axis=1)
    return np.asarray(np.sqrt(np.maximum(variance, 0.0)))
