"""Posterior distributions by quadrature in an adaptive box.

Threshold and log width have equidistant nodes, for which the trapezoidal rule converges fastest. The rates have
Gauss-Legendre nodes. The box starts around the mode. A face with density moves outwards, a face without density moves
inwards. With few trials the box extends far beyond most of the mass, so the nodes of the threshold are equidistant in
asinh of the distance from the mode.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from tactometry.psychometric import log_mixture

from ..arrays import Array, Rows
from .likelihood import BINOMIAL_BELOW, GUESS, LAPSE, LOG_WIDTH, N_PARAMETERS, THRESHOLD, linear, log_weight, weighted
from .log_posterior import LARGEST_ETA, LogPosterior, Prior, log_prior_of
from .mode import Mode

NEGLIGIBLE = 14.0
"""Points with a log density this far below that of the mode lie outside the box."""
FINAL_NODES = (37, 27)
RATE_NODES = 10
RATE_NODES_OF_FEW, FEW_TRIALS = 8, 40
"""With at most `FEW_TRIALS` trials a rate's density is wide, and fewer nodes change no interval end by 1e-5 of its
width."""
INTERIOR_RATE_NODES = 12
"""Number of nodes of a rate whose box does not begin at 0, which needs more nodes."""
SEARCH_NODES = (13, 11, 5, 5)
ETA_NODES = 10
ETA_SEARCH = (0.0, 0.15, 0.35, 0.6)
SINGLE_TRIALS = 3000
FEW = 3
"""Largest count of answers at a level whose probabilities are multiplied before taking the logarithm."""
FACTORS = 16
SMALLEST_RATE = 1e-18
"""Smallest rate for which a product of `FACTORS` probabilities does not underflow."""
START_SD = np.array([10.0, 10.0, 6.0, 6.0])
MAX_SEARCHES = 12
FINE = 40
"""Number of points per node at which the integral of a spline is evaluated."""
DENSE_SD, LEAST_DENSE = 2.0, 1 / 30
"""Nodes of the threshold are dense within this many SDs of the mode, at least within this fraction of the box."""


@dataclass(frozen=True)
class Marginals(Rows):
    """Posterior means and quantiles of the parameters.

    Means (n_sets, 4) contain the width itself, not its logarithm. `threshold` and `width` (n_sets, 3) are the lower end
    of the central interval, the median and the upper end; on the scale of `Counts.u`. `overdispersion` (n_sets,) is
    the posterior mean of eta, 0 for the binomial. `log_evidence` (n_sets,) is the log of the mean likelihood under the
    prior. `beyond` (n_sets, 2) contains the posterior shares of curves whose rise lies below, and above, all levels.
    `low` and `high` (n_sets, 4) are the box of the integral, NaN for shared grids.
    """

    mean: Array
    threshold: Array
    width: Array
    overdispersion: Array
    log_evidence: Array
    beyond: Array
    low: Array
    high: Array

    @classmethod
    def empty(cls, n: int) -> "Marginals":
        of_each, three, two = (np.full((n, size), np.nan) for size in (N_PARAMETERS, 3, 2))
        return cls(of_each, three, three, np.zeros(n), np.full(n, np.nan), two, of_each, of_each)


@dataclass(frozen=True)
class _Box(Rows):
    low: Array
    high: Array


def marginals(posterior: LogPosterior, mode: Mode, interval: float) -> Marginals:
    """Integrate the posteriors, with a separate grid for each data set."""
    if not len(posterior):
        return Marginals.empty(0)
    boxes = find_box(posterior, mode)
    lenses, by_set = _lenses(boxes, mode), []
    for here in _one_by_one(len(posterior)):
        etas = _eta_nodes(posterior[here], mode[here])
        by_set.append(_marginal_densities(posterior[here], boxes[here], lenses[here][0], etas))
    mean, threshold, log_width, eta, log_total, beyond = (np.array(column) for column in zip(*by_set, strict=True))
    centre, scale, start, stop = lenses.T
    threshold = centre[:, None] + scale[:, None] * np.sinh(quantiles(threshold, start, stop, interval))
    width = np.exp(quantiles(log_width, boxes.low[:, LOG_WIDTH], boxes.high[:, LOG_WIDTH], interval))
    log_evidence = log_total - posterior.prior.log_mass()
    return Marginals(mean, threshold, width, eta, log_evidence, beyond, boxes.low, boxes.high)


def _one_by_one(n_sets: int) -> list[slice]:
    """Return a slice for each data set."""
    return [slice(i, i + 1) for i in range(n_sets)]


def _lenses(boxes: _Box, mode: Mode) -> Array:
    """Return centre, scale, start and stop (n_sets, 4) of threshold nodes.

    Thresholds are centre + scale * sinh(t), with equidistant t from start to stop (the ends of the box).
    """
    low, high = boxes.low[:, THRESHOLD], boxes.high[:, THRESHOLD]
    centre, sd, reach = mode.theta[:, THRESHOLD], mode.sd[:, THRESHOLD], high - low
    scale = np.where(sd > 0, np.clip(DENSE_SD * sd, LEAST_DENSE * reach, reach), reach)
    return np.stack([centre, scale, *(np.arcsinh((end - centre) / scale) for end in (low, high))], axis=1)


def _eta_nodes(posterior: LogPosterior, mode: Mode) -> tuple[Array, Array]:
    """Return nodes of eta, and weights that include its prior."""
    if posterior.prior.overdispersion is None:
        return np.zeros(1), np.ones(1)
    axes = [mode.theta[0, place, None] for place in range(N_PARAMETERS)]
    tried = np.linspace(0.005, LARGEST_ETA, 100)
    along = np.array([log_density_grid(posterior, axes, eta).item() for eta in tried])
    kept = along + log_prior_of(tried) > mode.log_density[0] - NEGLIGIBLE
    # Extend the range, as it was found with the other parameters fixed at their mode.
    end = min(LARGEST_ETA, 1.3 * float(tried[kept].max(initial=0.005)))
    unit, weights = rate_rule(ETA_NODES)
    nodes = end * unit
    return nodes, weights * np.exp(log_prior_of(nodes))


def find_box(posterior: LogPosterior, mode: Mode) -> _Box:
    """Return the smallest box outside which the density is negligible."""
    ends = _Box(*posterior.prior.bounds())
    reach = np.where(mode.sd > 0, START_SD * mode.sd, np.inf)
    low, high = mode.theta - reach, mode.theta + reach
    box = _Box(np.maximum(low, ends.low), np.minimum(high, ends.high))
    open_sets = np.arange(len(posterior))
    for _ in range(MAX_SEARCHES):
        old = box[open_sets]
        searched = posterior[open_sets]
        by_set = [_profiles(searched[here], old[here]) for here in _one_by_one(len(searched))]
        profiles = [np.array(along) for along in zip(*by_set, strict=True)]
        new = _next_box(old, ends[open_sets], profiles, mode.log_density[open_sets])
        shift = np.abs(new.low - old.low) + np.abs(new.high - old.high)
        moved = shift > 0.2 * (old.high - old.low)
        box = box.replaced(open_sets, new)
        open_sets = open_sets[moved.any(axis=1)]
        if not len(open_sets):
            break
    return box


def _profiles(posterior: LogPosterior, box: _Box) -> list[Array]:
    axes = posterior.prior.search_axes(box.low[0], box.high[0], SEARCH_NODES)
    eta = posterior.prior.overdispersion
    etas = (0.0,) if eta is None else (float(eta[0]), *ETA_SEARCH)
    by_eta = [log_density_grid(posterior, axes, eta) + log_prior_of(eta) for eta in etas]
    density = np.maximum.reduce(by_eta)
    return [density.max(axis=others(place)) for place in range(N_PARAMETERS)]


def others(place: int) -> tuple[int, ...]:
    """Return all axes of a grid except `place`."""
    return tuple(axis for axis in range(N_PARAMETERS) if axis != place)


def _next_box(box: _Box, ends: _Box, profiles: list[Array], best: Array) -> _Box:
    low, high = box.low.copy(), box.high.copy()
    for place, profile in enumerate(profiles):
        if profile.shape[1] == 1:
            continue
        start, stop, n_steps = box.low[:, place], box.high[:, place], profile.shape[1] - 1
        size = stop - start
        step = size / n_steps
        highest = np.maximum(best, profile.max(axis=1))  # as coarse nodes may miss the mode
        inside = profile > highest[:, None] - NEGLIGIBLE
        first = inside.argmax(axis=1)
        last = n_steps - inside[:, ::-1].argmax(axis=1)
        # Faces with density move outwards; others move inwards to the first negligible node.
        start_moved = np.where(first == 0, start - 0.6 * size, start + (first - 1) * step)
        stop_moved = np.where(last == n_steps, stop + 0.6 * size, start + (last + 1) * step)
        low[:, place] = np.maximum(start_moved, ends.low[:, place])
        high[:, place] = np.minimum(stop_moved, ends.high[:, place])
    return _Box(low, high)


@cache
def rate_rule(n: int) -> tuple[Array, Array]:
    """Return Gauss-Legendre nodes from 0 to 1, with weights that sum to 2."""
    points, weights = np.polynomial.legendre.leggauss(n)
    return (points + 1) / 2, weights


def _nodes_in(
    prior: Prior, low: Array, high: Array, n_trials: float, lens: Array | None = None
) -> tuple[list[Array], list[Array]]:
    """Return nodes and weights along each parameter in a box.

    The thresholds are equidistant, or transformed by a lens (`_lenses`).
    """
    nodes, weights = [], []
    n_from_zero = RATE_NODES_OF_FEW if n_trials <= FEW_TRIALS else RATE_NODES
    for place in range(N_PARAMETERS):
        if place not in prior.free:
            unit, weight = np.zeros(1), np.ones(1)
        elif place in (LAPSE, GUESS):
            unit, weight = rate_rule(n_from_zero if low[place] == 0 else INTERIOR_RATE_NODES)
        else:
            unit = np.linspace(0, 1, FINAL_NODES[place])
            weight = np.ones(FINAL_NODES[place])
        if place == THRESHOLD and lens is not None:
            centre, scale, start, stop = lens
            t, size = start + (stop - start) * unit, high[place] - low[place]
            unit = (centre - low[place] + scale * np.sinh(t)) / size
            weight = scale * np.cosh(t) * (stop - start) / size
        nodes.append(low[place] + (high[place] - low[place]) * unit)
        weights.append(weight)
    return nodes, weights


def masses_in(posterior: LogPosterior, low: Array, high: Array) -> tuple[list[Array], Array]:
    """Return nodes in the box of one data set, and posterior masses."""
    axes, weights = _nodes_in(posterior.prior, low, high, posterior.counts.n_trials.sum())
    density = log_density_grid(posterior, axes, 0.0) + axes[LOG_WIDTH][:, None, None]
    return axes, np.exp(density - density.max()) * (weights[LAPSE][:, None] * weights[GUESS])


def log_density_grid(posterior: LogPosterior, axes: list[Array], eta: float) -> Array:
    """Return the log density of one data set at eta on the grid of four axes."""
    threshold, log_width, lapse, guess = posterior.prior.along(axes)
    log_prior = (threshold[:, None] + log_width)[..., None, None] + (lapse[:, None] + guess)
    return np.asarray(_log_likelihood_grid(posterior, axes, eta) + log_prior)


def _log_likelihood_grid(posterior: LogPosterior, axes: list[Array], eta: float) -> Array:
    shape, counts = posterior.shape, posterior.counts
    used = counts.n_trials[0] > 0
    k, n = counts.n_yes[0, used], counts.n_trials[0, used]
    lapse, guess = axes[LAPSE][:, None], posterior.prior.guess_nodes(axes[LAPSE], axes[GUESS])
    z = posterior.z_of(axes)  # the rates are two further axes
    if eta < BINOMIAL_BELOW and min(guess.min(), lapse.min()) < SMALLEST_RATE:
        log_cdf, log_sf = (log_part(z)[..., None, None] for log_part in (shape.log_cdf, shape.log_sf))
        yes, no = log_mixture(log_cdf, log_sf, guess, lapse)
        k, rest = (count[:, None, None, None, None] for count in (k, n - k))
        by_level = weighted(k, yes) + weighted(rest, no)
        return np.asarray(by_level.sum(axis=0))
    cdf, sf, _ = (share[..., None, None] for share in linear(shape, z))
    span = 1 - guess - lapse
    if eta < BINOMIAL_BELOW:
        # With asymptotes above 0, probabilities are sums of positive parts, so the linear scale is accurate.
        return _log_chances(cdf, guess, span, k) + _log_chances(sf, lapse, span, n - k)
    levels = zip(cdf, sf, k.tolist(), n.tolist(), strict=True)
    weights = (log_weight(guess + span * up, lapse + span * down, n_yes, size, eta) for up, down, n_yes, size in levels)
    return np.asarray(sum(weights))


def _log_chances(parts: Array, floor: Array, span: Array, count: Array) -> Array:
    """Sum count * log(floor + span * parts) over the levels."""
    few = (count <= FEW) & (len(count) > FACTORS)
    # Single precision halves the memory of a large grid; with few trials the error stays small.
    precision = np.float32 if count.sum() <= SINGLE_TRIALS else np.float64
    many = ~few & (count > 0)
    low, size = floor.astype(precision), span.astype(precision)
    rest = np.zeros((*parts.shape[1:3], *span.shape), dtype=precision)
    chance = np.empty_like(rest)  # reused for all levels, as allocation is slower than the computation
    for n, share in zip(count[many].astype(precision), parts[many].astype(precision), strict=True):
        np.add(low, np.multiply(size, share, out=chance), out=chance)
        rest += np.multiply(n, np.log(chance, out=chance), out=chance)
    if not few.any():
        return rest.astype(np.float64)
    return np.asarray(_log_products(np.repeat(parts[few], count[few].astype(int), axis=0), floor, span) + rest)


def _log_products(parts: Array, floor: Array, span: Array) -> Array:
    """Sum log(floor + span * parts) over the first axis.

    A product of `FACTORS` probabilities is a polynomial in floor and span. Its coefficients are the elementary
    symmetric polynomials of the parts, so one matrix product evaluates it at every rate.
    """
    floors, spans = (rate.ravel() for rate in np.broadcast_arrays(floor, span))
    total = np.zeros((parts.shape[1] * parts.shape[2], spans.size))
    for start in range(0, len(parts), FACTORS):
        factors = parts[start : start + FACTORS].reshape(-1, len(total))
        symmetric = np.zeros((len(factors) + 1, len(total)))
        symmetric[0] = 1
        for factor in factors:
            symmetric[1:] += factor * symmetric[:-1]
        power = np.arange(len(factors) + 1)[:, None]
        monomials = floors ** power[::-1] * spans**power
        total += np.log(symmetric.T @ monomials)
    return total.reshape(*parts.shape[1:3], *span.shape)


def _marginal_densities(
    posterior: LogPosterior, box: _Box, lens: Array, etas: tuple[Array, Array]
) -> tuple[Array, Array, Array, float, float, Array]:
    """Return means, marginal densities, log evidence and shares beyond."""
    prior, (low, high) = posterior.prior, (box.low[0], box.high[0])
    axes, weights = _nodes_in(prior, low, high, posterior.counts.n_trials.sum(), lens)
    densities = np.stack([log_density_grid(posterior, axes, float(eta)) for eta in etas[0]])
    densities += axes[LOG_WIDTH][:, None, None]  # the prior is on the width, the nodes on its logarithm
    highest = densities.max()
    densities -= highest  # avoids underflow of likelihoods
    masses = np.exp(densities, out=densities)
    masses *= weights[THRESHOLD][:, None, None, None] * (weights[LAPSE][:, None] * weights[GUESS])
    along_eta = etas[1] * masses.sum(axis=(1, 2, 3, 4))
    # a loop, as BLAS is slow for a single eta
    mass = sum(weight * at_eta for weight, at_eta in zip(etas[1], masses, strict=True))
    curve, rates = mass.sum(axis=(2, 3)), mass.sum(axis=(0, 1))
    along = [curve.sum(axis=1), curve.sum(axis=0), rates.sum(axis=1), rates.sum(axis=0)]
    nodes = [axes[THRESHOLD], np.exp(axes[LOG_WIDTH]), axes[LAPSE], axes[GUESS]]
    means = [(share * x).sum() / share.sum() for share, x in zip(along, nodes, strict=True)]
    mean = prior.tied(np.array(means))
    log_total = float(highest + np.log(curve.sum()) + prior.log_cell(low, high, curve.shape))
    beyond = (posterior.beyond_levels(axes) * curve).sum(axis=(1, 2)) / curve.sum()
    mean_eta = float((along_eta * etas[0]).sum() / along_eta.sum())
    return mean, along[THRESHOLD], along[LOG_WIDTH], mean_eta, log_total, beyond


def quantiles(density: Array, low: Array, high: Array, interval: float) -> Array:
    """Return lower end, median and upper end (n_sets, 3) of densities."""
    shares = np.array([(1 - interval) / 2, 0.5, (1 + interval) / 2])
    n_nodes = density.shape[1]
    fine, weights = spline_integral(n_nodes)
    integral = density @ weights
    # Make the integral monotone for inversion, as a spline may dip below 0 between nodes.
    cumulated = np.maximum.accumulate(integral, axis=1)
    places = np.array([np.interp(shares * row[-1], row, fine) for row in cumulated])
    above_low = (high - low)[:, None] * places / (n_nodes - 1)
    return np.asarray(low[:, None] + above_low)


@cache
def spline_integral(n_nodes: int) -> tuple[Array, Array]:
    """Return points between nodes, and weights of integrals up to them.

    The weights (n_nodes, n_places) are those of a cubic spline without knots at the second and the second to last
    node. The tests compare it with `scipy.interpolate`, which is slow to load.
    """
    inner = np.arange(1, n_nodes - 1)
    left, right = np.zeros((2, n_nodes, n_nodes))
    for offset, of_moment, of_value in ((-1, 1, 6), (0, 4, -12), (1, 1, 6)):
        left[inner, inner + offset], right[inner, inner + offset] = of_moment, of_value
    left[0, :3] = left[-1, -3:] = 1, -2, 1
    values, moments = np.eye(n_nodes), np.asarray(np.linalg.solve(left, right), dtype=np.float64)
    steps = (values[:-1] + values[1:]) / 2 - (moments[:-1] + moments[1:]) / 24
    before = np.concatenate([np.zeros((1, n_nodes)), steps.cumsum(axis=0)])
    places = np.linspace(0, n_nodes - 1, FINE * n_nodes)
    node = np.minimum(places.astype(np.intp), n_nodes - 2)
    t = (places - node)[:, None]
    integral = before[node] + values[node] * (t - t**2 / 2) + values[node + 1] * t**2 / 2
    integral -= moments[node] * (t**2 - t**3 + t**4 / 4) / 6 + moments[node + 1] * (t**2 / 2 - t**4 / 4) / 6
    return places, np.ascontiguousarray(integral.T)
