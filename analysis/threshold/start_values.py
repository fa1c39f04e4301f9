"""Start values for the search for a mode.

Start values are maxima on a coarse grid, and step functions, whose density has a closed form.

A density may have several local maxima, such as a shallow function without lapses and steep functions between two
levels.
"""

from dataclasses import dataclass
from functools import reduce
from itertools import product

import numpy as np

from ..arrays import Array, Bools, Indices, Rows
from .counts import Counts
from .likelihood import GUESS, LAPSE, N_PARAMETERS, constant_log_likelihood, log_chances_by_curve, weighted
from .log_posterior import LARGEST_RATE, LogPosterior, Prior, log_rate

N_WIDTHS = 10
WIDEST_NODE, NARROWEST_NODE = 2.8, 0.03
BEYOND = np.array([0.6, 0.75, 0.93])
"""Threshold nodes outside the range of the levels (absolute u)."""
MOST_PLACES = 25
RATES = {1: (0.003, 0.03, 0.1, 0.25, 0.45), 2: (0.003, 0.05, 0.2, 0.42)}
"""Nodes of each free rate, by the number of free rates."""
LOW = 25.0
"""Log density below the highest node, beyond which a local maximum is ignored."""
CLOSE = 3.0
"""Difference in log density within which the best node of another rate may lead to a higher maximum."""
CHUNK = 2_000_000
FLOOR = -1e6
N_STEPS = 3
STEEP = 0.7
"""Width of a steep start, in spacings of levels."""


@dataclass(frozen=True)
class Starts(Rows):
    """Start values `theta` (n_starts, 4) of the data sets `sets` (n_starts,)."""

    sets: Indices
    theta: Array

    @classmethod
    def none(cls) -> "Starts":
        return cls(np.zeros(0, dtype=np.int64), np.zeros((0, N_PARAMETERS)))


# --- starts on a coarse grid
def grid_starts(posterior: LogPosterior) -> tuple[Starts, Starts]:
    """Return local maxima of a grid, and best narrow and wide nodes."""
    counts, prior = posterior.counts, posterior.prior
    summits, halves = [Starts.none()], [Starts.none()]
    for members in posterior.alike():
        nodes = _nodes(prior, counts[members[:1]])
        curves, flat = nodes.reshape(len(nodes), -1, N_PARAMETERS), nodes.reshape(-1, N_PARAMETERS)
        by_curve = log_chances_by_curve(posterior.shape, counts.u[members[0]], curves)
        # Minus infinity times a count of 0 would be NaN.
        log_chances = np.maximum(np.concatenate(by_curve, axis=2), FLOOR).reshape(len(flat), -1)
        size = max(1, CHUNK // len(flat))
        for sets in (members[start : start + size] for start in range(0, len(members), size)):
            density = _answers(counts[sets]) @ log_chances.T
            density += prior[sets[:1]].log_density(flat[None])
            tops, bests = _tops(sets, density.reshape(len(sets), *nodes.shape[:-1]), nodes)
            summits.append(tops)
            halves.append(bests)
    return reduce(Starts.joined, summits), reduce(Starts.joined, halves)


def _nodes(prior: Prior, one: Counts) -> Array:
    """Return the grid (n_rates, n_widths, n_thresholds, 4) of one data set."""
    narrow = min(max(1.3 * float(one.gap[0]), NARROWEST_NODE), 1.5)
    has_two_rates = LAPSE in prior.free and GUESS in prior.free
    rates = RATES[2 if has_two_rates else 1]
    log_widths = np.linspace(np.log(narrow), np.log(WIDEST_NODE), N_WIDTHS).tolist()
    thresholds = _places(one.u[0, one.n_trials[0] > 0]).tolist()
    lapses = rates if prior.lapse_rate is None else [prior.lapse_rate]
    guesses = rates if GUESS in prior.free else [prior.guess_rate or 0.0]
    # Rates are the first axis, so that the search for the best one uses contiguous memory.
    nodes = np.array(list(product(lapses, guesses, log_widths, thresholds)))[:, [3, 2, 0, 1]]
    return prior.tied(nodes.reshape(-1, len(log_widths), len(thresholds), N_PARAMETERS))


def _places(levels: Array) -> Array:
    x = np.unique(np.clip(levels, -BEYOND[-1], BEYOND[-1]))
    inside = np.concatenate([x, (x[1:] + x[:-1]) / 2])
    if len(inside) > MOST_PLACES or not len(inside):
        inside = np.linspace(-0.5, 0.5, MOST_PLACES)
    both = np.concatenate([-BEYOND, BEYOND])
    outside = both[(both < inside.min()) | (both > inside.max())]
    return np.unique(np.concatenate([inside, outside]))


def _answers(counts: Counts) -> Array:
    return np.concatenate([counts.n_yes, counts.n_trials - counts.n_yes], axis=1)


def _tops(sets: Indices, density: Array, nodes: Array) -> tuple[Starts, Starts]:
    """Return the local maxima, and the best nodes of narrow and wide widths."""
    ridge = density.max(axis=1)
    high = ridge >= ridge.max(axis=(1, 2), keepdims=True) - LOW
    summits = _at_best_rate(sets, density, nodes, *np.nonzero(_is_top(ridge) & high))
    every, middle = np.arange(len(sets)), ridge.shape[1] // 2
    halves = []
    for first, half in ((0, ridge[:, :middle]), (middle, ridge[:, middle:])):
        width, place = np.divmod(half.reshape(len(sets), -1).argmax(axis=1), ridge.shape[2])
        halves.append(_at_best_rate(sets, density, nodes, every, first + width, place))
    return summits.joined(_of_other_rates(sets, density, nodes)), halves[0].joined(halves[1])


def _at_best_rate(sets: Indices, density: Array, nodes: Array, row: Indices, width: Indices, place: Indices) -> Starts:
    rate = density[row, :, width, place].argmax(axis=1)
    return Starts(sets[row], nodes[rate, width, place])


def _of_other_rates(sets: Indices, density: Array, nodes: Array) -> Starts:
    """Return the best node of each other rate, if within `CLOSE`."""
    n_rates = density.shape[1]
    by_rate = density.reshape(len(sets), n_rates, -1)
    node = by_rate.argmax(axis=2)
    height = np.take_along_axis(by_rate, node[..., None], axis=2)[..., 0]
    highest = height.max(axis=1, keepdims=True)
    i, r = np.nonzero((height >= highest - CLOSE) & (height < highest))
    return Starts(sets[i], nodes.reshape(n_rates, -1, N_PARAMETERS)[r, node[i, r]])


def _is_top(ridge: Array) -> Bools:
    """Return True for local maxima; of equal neighbours only the first counts."""
    _, a, b = ridge.shape
    padded = np.pad(ridge, ((0, 0), (1, 1), (1, 1)), constant_values=-np.inf)
    top = np.ones(ridge.shape, dtype=bool)
    for i, j in ((0, 1), (1, -1), (1, 0), (1, 1)):  # each direction is tested together with its opposite
        ahead = padded[:, 1 + i : a + 1 + i, 1 + j : b + 1 + j]
        behind = padded[:, 1 - i : a + 1 - i, 1 - j : b + 1 - j]
        top &= (ridge >= ahead) & (ridge > behind)
    return top


# --- starts by steps
def step_starts(posterior: LogPosterior, at_least: Array) -> Starts:
    """Return the best steps with a log density of `at_least` (n_sets,)."""
    steps = (_steps_between(posterior), _steps_at(posterior))
    density, theta = (np.concatenate(both, axis=1) for both in zip(*steps, strict=True))
    best = np.argsort(-density, axis=1)[:, :N_STEPS]
    densest = np.take_along_axis(density, best, axis=1)
    sets, place = np.nonzero(densest >= at_least[:, None])
    return Starts(sets, theta[sets, best[sets, place]])


def _spacings(counts: Counts) -> Array:
    """Return the spacings of neighbouring levels, infinite if unused."""
    used = counts.n_trials > 0
    return np.where(used[:, 1:] & used[:, :-1], np.diff(counts.u, axis=1), np.inf)


def _steep_width(counts: Counts, spacing: Array) -> Array:
    finite = np.where(np.isfinite(spacing), spacing, 1.0)
    return np.maximum(1.5 * counts.gap[:, None], STEEP * finite)


def _steps_between(posterior: LogPosterior) -> tuple[Array, Array]:
    """Return the log densities and parameters of steps between two levels."""
    u, spacing = posterior.counts.u, _spacings(posterior.counts)
    cut = np.arange(1, u.shape[1])
    density, lapse, guess = _asymptotes(posterior, cut, cut)
    middle, width = (u[:, 1:] + u[:, :-1]) / 2, _steep_width(posterior.counts, spacing)
    theta = np.stack([middle, np.log(width), lapse, guess], axis=-1)
    return np.where(np.isfinite(spacing), density, -np.inf), theta


def _steps_at(posterior: LogPosterior) -> tuple[Array, Array]:
    """Return log densities and parameters of steps at a level."""
    shape, counts = posterior.shape, posterior.counts
    u, k, n = counts.u, counts.n_yes, counts.n_trials
    spacing, outer = _spacings(counts), np.full((len(counts), 1), np.inf)
    to_lower, to_upper = np.hstack([outer, spacing]), np.hstack([spacing, outer])
    nearest = np.minimum(to_lower, to_upper)
    at = np.arange(u.shape[1])
    density, lapse, guess = _asymptotes(posterior, at, at + 1)
    rate = np.divide(k, n, out=np.full_like(k, 0.5), where=n > 0)
    # Clip the rate, as a rate equal to an asymptote means an infinite threshold.
    span = np.maximum(1 - guess - lapse, 1e-9)
    share = np.clip((rate - guess) / span, 0.03, 0.97)
    shift = (shape.at(np.log(share), np.log1p(-share)) - shape.z50) / shape.z_width
    width = _steep_width(counts, nearest)
    theta = np.stack([u - shift * width, np.log(width), lapse, guess], axis=-1)
    return np.where(n > 0, density + constant_log_likelihood(k, n), -np.inf), theta


def _asymptotes(posterior: LogPosterior, below: Indices, above: Indices) -> tuple[Array, Array, Array]:
    """Return log density, lapse and guess rate of steps."""
    counts, prior = posterior.counts, posterior.prior
    none = np.zeros((len(counts), 1))
    # Entry i sums the answers and trials of all levels before level i.
    k, n = (np.hstack([none, np.cumsum(count, axis=1)]) for count in (counts.n_yes, counts.n_trials))
    alarms, catch = prior.n_false_alarms[:, None], prior.n_catch[:, None]
    k_low, n_low = k[:, below], n[:, below]
    n_up = n[:, -1:] - n[:, above]
    misses = n_up - (k[:, -1:] - k[:, above])
    guess = _rate(k_low + alarms, n_low + catch, prior.guess_rate, prior.guess_beta)
    lapse = _rate(misses, n_up, prior.lapse_rate, prior.lapse_beta)
    if prior.equal_asymptotes:
        guess = lapse = _rate(k_low + misses, n_low + n_up, None, prior.lapse_beta)
    density = _log_chance(k_low, n_low, guess) + _log_chance(misses, n_up, lapse)
    if GUESS in prior.free:
        density = density + log_rate(guess, alarms, catch - alarms, prior.guess_beta)[0]
    if prior.lapse_rate is None:
        density = density + log_rate(lapse, none, none, prior.lapse_beta)[0]
    return density, lapse, guess


def _rate(k: Array, n: Array, fixed: float | None, beta: float) -> Array:
    """Return the mode of a rate under its prior, or the fixed rate."""
    if fixed is not None:
        return np.full(k.shape, fixed)
    mode = k / (n + beta - 1)  # mode of Beta(1 + k, beta + n - k)
    return np.clip(mode, 1e-6, LARGEST_RATE)


def _log_chance(k: Array, n: Array, rate: Array) -> Array:
    with np.errstate(divide="ignore"):
        log_chance = weighted(k, np.log(rate)) + weighted(n - k, np.log1p(-rate))
    return np.maximum(log_chance, FLOOR)
