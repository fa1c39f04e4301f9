"""Posterior modes of very many tracks, for simulations: the numbers of `fit` with the method ``map``, without status,
interval and notes.

Levels that the tracks share are weighed on one coarse grid, in a product of matrices. The climb begins at its best
node, and at that of the other half of the widths where it is about as good; a single fit climbs from every summit, and
finds a higher one in one of 200 tracks of 140 trials (one of 40 with a free lapse rate).
"""

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments.require import expect
from tactometry.psychometric import shape_named

from ..arrays import Array, Bools, Rows
from .counts import count_arrays, normalise
from .estimates import is_regular
from .fitting import check_rates
from .likelihood import LOG_WIDTH, THRESHOLD, log_chances_by_curve
from .log_posterior import LogPosterior
from .mode import Mode, climb, find_mode
from .prior import Prior
from .start_values import Starts

MOST_SHARED = 64
"""Levels on a common grid; of more (QUEST places its levels anywhere) each track is searched for itself."""
N_THRESHOLDS, N_WIDTHS = 24, 8
NARROWEST, WIDEST = 0.05, 2.0
"""Of the grid's widths, in ranges of all levels."""
RATES = (0.003, 0.05, 0.2)
SMALL_DECREMENT = 1e-10
"""In log density: a threshold is then within a ten-thousandth of its standard error."""
FLOOR = -1e6
CLOSE = 1.5
"""In log density: the best narrow and the best wide node may lead to summits of either order."""


@dataclass(frozen=True)
class TrackModes(Rows):
    """Of each track, (n_sets,): threshold and its standard error, width, and whether the curvature there is one to rest
    on (else the answers hold no threshold, or a step)."""

    thresholds: Array
    standard_errors: Array
    widths: Array
    regular: Bools


def fit_modes(
    levels: ArrayLike,
    answers: ArrayLike,
    *,
    shape: str,
    guess_rate: float | None,
    lapse_rate: float | None = None,
    scale_free_width: bool = True,
) -> TrackModes:
    """The mode of each track's posterior.

    Parameters
    ----------
    levels, answers : (n_sets, n_trials) array
        The level of each trial and its answer, 1 or 0; trials at the level NaN are none.
    shape, guess_rate, lapse_rate, scale_free_width
        As of `tactometry.analysis.threshold.fitting.fit`; a shape on levels, not on their logarithms.

    Raises
    ------
    InvalidParameter
        If rates are none, arrays do not match, or an answer is neither 1 nor 0.

    >>> x = np.tile([10.0, 14.0, 18.0, 22.0, 26.0], (1, 8))
    >>> found = fit_modes(x, x > [[16.0] * 20 + [20.0] * 20], shape="normal", guess_rate=0.0, lapse_rate=0.02)
    >>> found.thresholds.round().tolist(), found.regular.tolist()
    ([18.0], [True])
    """
    check_rates("fit_modes", guess_rate, lapse_rate)
    x, y = np.asarray(levels, dtype=np.float64), np.asarray(answers, dtype=np.float64)
    expect(
        x.ndim == 2 and x.shape == y.shape, "fit_modes", f"shapes {x.shape}, {y.shape}", "(n_sets, n_trials) of both"
    )
    curve, used = shape_named(shape), ~np.isnan(x)
    expect(not curve.on_log_levels, "fit_modes.shape", shape, "a shape on levels")
    expect(np.isin(y[used], (0, 1)).all(), "fit_modes.answers", "another value", "1 or 0")
    shared = np.unique(x[used])
    are_shared = 2 <= len(shared) <= MOST_SHARED
    pooled = _pooled(shared, x, y, used) if are_shared else (np.where(used, x, 0.0), np.where(used, y, 0.0), used)
    counts = normalise(*count_arrays(*pooled))
    none = np.zeros(len(counts))
    prior = Prior(counts.gap, lapse_rate, guess_rate, none, none, scale_free_width=scale_free_width)
    posterior = LogPosterior(curve, counts, prior)
    if are_shared:
        starts, again = _starts(posterior, *pooled)
        mode = _highest(climb(posterior, starts, small_decrement=SMALL_DECREMENT), posterior, again)
    else:
        mode = find_mode(posterior)
    at = counts.centre + counts.spread * mode.theta[:, THRESHOLD]
    widths = counts.spread * np.exp(mode.theta[:, LOG_WIDTH])
    return TrackModes(at, counts.spread * mode.sd[:, THRESHOLD], widths, is_regular(mode) & (counts.n_levels > 1))


def _pooled(shared: Array, x: Array, y: Array, used: Bools) -> tuple[Array, Array, Array]:
    """Levels (1, n_levels), and how many answers are 1 and how many there are at each, (n_sets, n_levels)."""
    shape = (len(x), len(shared))
    cells = (np.arange(len(x))[:, None] * shape[1] + np.searchsorted(shared, x))[used]
    size = shape[0] * shape[1]
    n_yes = np.bincount(cells, weights=y[used], minlength=size).reshape(shape)
    n_trials: Array = np.bincount(cells, minlength=size).reshape(shape).astype(np.float64)
    return shared[None], np.asarray(n_yes, dtype=np.float64), n_trials


def _starts(posterior: LogPosterior, levels: Array, n_yes: Array, n_trials: Array) -> tuple[Array, Starts]:
    """The best node (n_sets, 4) of a grid over all levels for each track, on the scale of its own levels, and that of
    the other half of the widths where it is about as good."""
    low, high = levels.min(), levels.max()
    centre, spread = (low + high) / 2, high - low
    nodes = _nodes(posterior.prior)
    by_curve = log_chances_by_curve(posterior.shape, (levels[0] - centre) / spread, nodes[:, None])
    yes, no = (np.maximum(log_chance, FLOOR).reshape(len(nodes), -1) for log_chance in by_curve)
    density = n_yes @ yes.T + (n_trials - n_yes) @ no.T
    is_wide = nodes[:, LOG_WIDTH] > np.median(nodes[:, LOG_WIDTH])
    halves = [np.where(half, density, -np.inf) for half in (~is_wide, is_wide)]
    best = np.stack([_on_own_scale(nodes[half.argmax(axis=1)], posterior, centre, spread) for half in halves])
    height, at = np.stack([half.max(axis=1) for half in halves]), np.arange(len(density))
    better = height.argmax(axis=0)
    close = np.flatnonzero(np.abs(height[0] - height[1]) < CLOSE)
    return best[better, at], Starts(close, best[1 - better[close], close])


def _on_own_scale(nodes: Array, posterior: LogPosterior, centre: float, spread: float) -> Array:
    own, counts = nodes.copy(), posterior.counts
    own[:, THRESHOLD] = (centre + spread * own[:, THRESHOLD] - counts.centre) / counts.spread
    own[:, LOG_WIDTH] += np.log(spread / counts.spread)
    return own


def _highest(mode: Mode, posterior: LogPosterior, again: Starts) -> Mode:
    """With the modes that other starts of some tracks lead to, where they are higher."""
    if not len(again.sets):
        return mode
    other = climb(posterior[again.sets], again.theta, small_decrement=SMALL_DECREMENT)
    higher = other.log_density > mode.log_density[again.sets]
    return mode.replaced(again.sets[higher], other[np.flatnonzero(higher)])


def _nodes(prior: Prior) -> Array:
    """(n_nodes, 4), on the scale of all levels."""
    thresholds, log_widths = (
        np.linspace(-0.6, 0.6, N_THRESHOLDS),
        np.linspace(np.log(NARROWEST), np.log(WIDEST), N_WIDTHS),
    )
    lapses, guesses = (RATES if rate is None else (rate,) for rate in (prior.lapse_rate, prior.guess_rate))
    return np.array(list(product(thresholds, log_widths, lapses, guesses)))
