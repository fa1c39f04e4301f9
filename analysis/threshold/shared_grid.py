"""Posteriors of many data sets on the same levels: one grid for all, so that a product of matrices gives every
log-likelihood.

The grid spans where any of the data sets holds density, at `STEP_SD` of a typical standard deviation. A data set
whose posterior is too narrow for it is told as unresolved, and is for `posterior.marginals`, which lays a grid of
its own. Against four times as many nodes, means and standard deviations differ by at most 0.2 % of the standard
deviation, the ends of the intervals by 0.1 % of their width (tests), as long as `RESOLVED_STEPS` holds.
"""

from dataclasses import dataclass, replace

import numpy as np

from tactometry.psychometric import Shape

from ..arrays import Array, Bools
from .chances import linear
from .counts import Counts
from .likelihood import GUESS, LAPSE, LOG_WIDTH, N_PARAMETERS, THRESHOLD
from .mode import Mode
from .posterior import NEGLIGIBLE, Marginals, beyond_levels, log_cell, marginals, marginals_of, rate_rule
from .prior import Prior, log_mass, log_prior_axes
from .starts import same_rows

MOST_FREE = 3
"""With two free rates a grid for all has so many nodes that grids of their own are faster."""
WORTH_SHARING = 8
"""Fewer data sets get grids of their own."""
SEARCH_NODES = (41, 21, 6, 6)
MODE_SD = 6.0
"""The grid reaches at least so many standard deviations beyond each mode."""
RATE_NODES = 12
STEP_SD = 0.5
TYPICAL = 0.1
"""The step is that for this quantile of the standard deviations."""
FEWEST_NODES, MOST_NODES = 25, (161, 61)
RESOLVED_STEPS = 1.5
"""A standard deviation has at least so many steps of the grid."""
RESOLVED_RATE = 0.02
"""And that of a rate at least this part of its range."""
CHUNK = 4_000_000
"""Nodes times data sets at once: 16 MB in single precision."""


@dataclass(frozen=True)
class Grid:
    """Nodes and log weights along the four parameters, and the logarithm of the volume of a cell."""

    nodes: list[Array]
    log_weights: list[Array]
    log_cell: float

    @property
    def sizes(self) -> tuple[int, ...]:
        return tuple(len(axis) for axis in self.nodes)

    def step(self, place: int) -> float:
        return float(self.nodes[place][1] - self.nodes[place][0])


def batched_marginals(shape: Shape, counts: Counts, prior: Prior, mode: Mode, interval: float) -> Marginals:
    """As `posterior.marginals`: data sets on the same levels share a grid, the others have their own."""
    all_sets = Marginals.empty(len(counts))
    is_alone = np.ones(len(counts), dtype=bool)
    if prior.overdispersion is None and len(prior.free) <= MOST_FREE:
        catch = np.stack([prior.n_false_alarms, prior.n_catch], axis=1)  # the prior of a free guess rate holds them
        for members in same_rows(np.hstack([counts.u, counts.n_trials > 0, catch])):
            if len(members) >= WORTH_SHARING:
                shared, resolved = _shared(shape, counts[members], prior[members], mode[members], interval)
                all_sets.put(members[resolved], shared, resolved)
                is_alone[members[resolved]] = False
    alone = np.flatnonzero(is_alone)
    by_themselves = marginals(shape, counts[alone], prior[alone], mode[alone], interval)
    all_sets.put(alone, by_themselves, np.ones(len(alone), dtype=bool))
    return all_sets


def _shared(shape: Shape, counts: Counts, prior: Prior, mode: Mode, interval: float) -> tuple[Marginals, Bools]:
    """And which of the data sets the grid resolves."""
    grid = common_grid(shape, counts, prior, mode)
    along, log_total, beyond = marginal_masses(shape, counts, prior, grid)
    shared = _described(grid, along, log_total - log_mass(prior), beyond, interval)
    return replace(shared, mean=prior.tied(shared.mean)), _resolved(prior, grid, along)


def common_grid(shape: Shape, counts: Counts, prior: Prior, mode: Mode) -> Grid:
    """The grid of data sets on the same levels."""
    low, high = (end[0] for end in prior.bounds())
    for _ in range(2):  # the first coarse search spans all that the priors allow, the second what that one has left
        low, high = _shrunk(shape, counts, prior, mode, _search_grid(prior, low, high))
    return _final_grid(prior, low, high, _sizes(mode, high - low))


def _sizes(mode: Mode, reach: Array) -> list[int]:
    """Numbers of nodes along threshold and log width."""
    sizes, sd = [], np.sqrt(np.diagonal(mode.covariance, axis1=1, axis2=2))
    for place, most in zip((THRESHOLD, LOG_WIDTH), MOST_NODES, strict=True):
        known = sd[sd[:, place] > 0, place]  # a mode on a bound has none
        typical = float(np.quantile(known, TYPICAL)) if len(known) else 1.0
        sizes.append(int(np.clip(reach[place] / (STEP_SD * typical), FEWEST_NODES, most)))
    return sizes


def _search_grid(prior: Prior, low: Array, high: Array) -> Grid:
    nodes = [
        np.linspace(max(low[place], 1e-9 if place in (LAPSE, GUESS) else -np.inf), high[place], n)
        if place in prior.free
        else low[place, None]
        for place, n in enumerate(SEARCH_NODES)
    ]
    return Grid(nodes, [np.zeros(len(axis)) for axis in nodes], 0.0)


def _final_grid(prior: Prior, low: Array, high: Array, sizes: list[int]) -> Grid:
    nodes = [np.linspace(low[place], high[place], n) for place, n in enumerate(sizes)]
    log_weights = [np.zeros(sizes[0]), nodes[LOG_WIDTH]]  # the density is one of the width itself
    for place in (LAPSE, GUESS):
        unit, weight = rate_rule(RATE_NODES) if place in prior.free else (np.zeros(1), np.ones(1))
        nodes.append(low[place] + (high[place] - low[place]) * unit)
        log_weights.append(np.log(weight))
    return Grid(nodes, log_weights, log_cell(prior, low, high, sizes))


def _tables(shape: Shape, counts: Counts, prior: Prior, grid: Grid) -> tuple[Array, Array]:
    """log psi and log(1 - psi) of the levels used (2 n_levels, n_nodes), and the log prior times weight (n_nodes,)."""
    used = counts.n_trials[0] > 0
    m, v, lapse, guess = grid.nodes
    z = shape.z50 + (counts.u[0, used][:, None, None] - m[:, None]) * (shape.z_width * np.exp(-v))
    cdf, sf, _ = linear(shape, z)
    guess = prior.guess_nodes(lapse, guess)
    span = 1 - guess - lapse[:, None]
    with np.errstate(divide="ignore"):
        yes = np.log(guess + span * cdf[..., None, None])
        no = np.log(lapse[:, None] + span * sf[..., None, None])
        along = zip(log_prior_axes(prior[:1], grid.nodes), grid.log_weights, strict=True)
        m, v, lapse, guess = (log_density + log_weight for log_density, log_weight in along)
    outside = (m[:, None] + v)[..., None, None] + (lapse[:, None] + guess)
    table = np.concatenate([yes.reshape(used.sum(), -1), no.reshape(used.sum(), -1)])
    # Minus infinity would make NaN of the answers that a level does not have.
    return np.maximum(table, -1e6), np.maximum(outside, -1e9).ravel()


def _answers(counts: Counts) -> Array:
    used = counts.n_trials[0] > 0
    return np.hstack([counts.n_yes[:, used], (counts.n_trials - counts.n_yes)[:, used]])


def _shrunk(shape: Shape, counts: Counts, prior: Prior, mode: Mode, grid: Grid) -> tuple[Array, Array]:
    """The ends of the nodes between which any data set holds density, one node more on each side."""
    table, outside = _tables(shape, counts, prior, grid)
    answers, kept = _answers(counts), np.zeros(len(outside), dtype=bool)
    for chunk in _chunks(len(counts), len(outside)):
        density = answers[chunk] @ table + outside
        best = np.maximum(density.max(axis=1), mode.log_density[chunk])
        kept |= (density > best[:, None] - NEGLIGIBLE).any(axis=0)
    inside = kept.reshape(grid.sizes)
    # Coarse nodes may miss a narrow posterior between them; its mode and curvature know where it lies.
    around = MODE_SD * np.sqrt(np.diagonal(mode.covariance, axis1=1, axis2=2))
    low, high = (mode.theta - around).min(axis=0), (mode.theta + around).max(axis=0)
    for place, nodes in enumerate(grid.nodes):
        others = tuple(j for j in range(N_PARAMETERS) if j != place)
        along = np.flatnonzero(inside.any(axis=others))
        first, last = (max(along[0] - 1, 0), min(along[-1] + 1, len(nodes) - 1)) if len(along) else (0, -1)
        low[place] = max(min(low[place], nodes[first]), nodes[0])
        high[place] = min(max(high[place], nodes[last]), nodes[-1])
    return low, high


def _chunks(n_sets: int, n_nodes: int) -> list[slice]:
    size = max(1, CHUNK // n_nodes)
    return [slice(start, start + size) for start in range(0, n_sets, size)]


def marginal_masses(shape: Shape, counts: Counts, prior: Prior, grid: Grid) -> tuple[list[Array], Array, Array]:
    """Along each parameter the masses (n_sets, n_nodes) of every data set, the logarithms of their integrals (n_sets,),
    and the shares (n_sets, 2) beyond the levels."""
    table, outside = _tables(shape, counts, prior, grid)
    answers, (n_m, n_v, n_lapse, n_guess) = _answers(counts), grid.sizes
    beyond = beyond_levels(shape, counts, grid.nodes).reshape(2, -1).T
    chunks = []
    for chunk in _chunks(len(counts), len(outside)):
        density = answers[chunk] @ table + outside
        highest = density.max(axis=1, keepdims=True)
        density -= highest
        mass = np.exp(density.astype(np.float32)).reshape(len(density), n_m * n_v, n_lapse * n_guess)
        ones = np.ones(n_lapse * n_guess, dtype=np.float32)
        flat, rates = mass @ ones, mass.sum(axis=1).reshape(-1, n_lapse, n_guess)
        curve, total = flat.reshape(-1, n_m, n_v), flat.sum(axis=1, dtype=np.float64)
        along = (curve.sum(axis=2), curve.sum(axis=1), rates.sum(axis=2), rates.sum(axis=1))
        log_total = highest[:, 0] + np.log(total) + grid.log_cell
        chunks.append((*along, log_total, flat @ beyond / total[:, None]))
    columns = [np.concatenate(column).astype(np.float64) for column in zip(*chunks, strict=True)]
    return columns[:N_PARAMETERS], columns[-2], columns[-1]


def _described(grid: Grid, along: list[Array], log_evidence: Array, beyond: Array, interval: float) -> Marginals:
    values = [grid.nodes[THRESHOLD], np.exp(grid.nodes[LOG_WIDTH]), grid.nodes[LAPSE], grid.nodes[GUESS]]
    mean = np.stack([(mass @ x) / mass.sum(axis=1) for mass, x in zip(along, values, strict=True)], axis=1)
    ends = []
    for place in (THRESHOLD, LOG_WIDTH):
        low, high = (np.full(len(mean), grid.nodes[place][end]) for end in (0, -1))
        ends.append((along[place], low, high))
    return marginals_of(mean, ends, np.zeros(len(mean)), log_evidence, beyond, interval)


def _resolved(prior: Prior, grid: Grid, along: list[Array]) -> Bools:
    resolved = np.ones(len(along[0]), dtype=bool)
    for place in prior.free:
        is_rate = place in (LAPSE, GUESS)
        finest = RESOLVED_RATE * grid.nodes[place][-1] if is_rate else RESOLVED_STEPS * grid.step(place)
        resolved &= _spread(along[place], grid.nodes[place]) > finest
    return resolved


def _spread(mass: Array, nodes: Array) -> Array:
    """Standard deviation (n_sets,) of masses (n_sets, n_nodes)."""
    share = mass / mass.sum(axis=1, keepdims=True)
    mean = share @ nodes
    return np.asarray(np.sqrt(np.maximum((share * np.square(nodes - mean[:, None])).sum(axis=1), 0.0)))
