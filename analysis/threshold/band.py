"""Pointwise posterior band of a psychometric function."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments.require import between, finite_array

from ..arrays import Array
from .fitting import log_posterior
from .likelihood import N_PARAMETERS, THRESHOLD, log_chances
from .log_posterior import LogPosterior
from .mode import find_mode
from .posterior import find_box, masses_in

N_DRAWS = 500
"""Number of curves drawn from the posterior; the ends of a 95 % band are near the thirteenth curve from each side."""


@dataclass(frozen=True)
class CurveBand:
    """Lower end, median and upper end of psi at `levels`, and of threshold."""

    levels: Array
    low: Array
    median: Array
    high: Array
    threshold: tuple[float, float, float]


def curve_band(
    levels: ArrayLike,
    n_correct: ArrayLike,
    n_trials: ArrayLike,
    at: ArrayLike,
    *,
    interval: float = 0.95,
    **options: Any,
) -> CurveBand | None:
    """Return the posterior band of a psychometric function at levels `at`.

    - `levels`, `n_correct`, `n_trials`: As for `fit`. With fewer than two levels the result is None.
    - `at`: Levels at which to compute the band, in the same unit.
    - `interval`: Coverage at each level, between 0 and 1.
    - `**options`: ``shape``, ``guess_rate`` and the other options of `log_posterior`.

    Examples
    --------
    >>> band = curve_band([1, 2, 3, 4, 5], [0, 1, 5, 9, 10], 10, [1, 3, 5], shape="normal", guess_rate=0.0)
    >>> bool((band.low < band.median).all() and (band.median < band.high).all())
    True
    """
    between("curve_band", 0, 1, interval=interval)
    places = finite_array("at", at)
    columns = (np.atleast_1d(np.asarray(values))[None] for values in (levels, n_correct, n_trials))
    posterior = log_posterior(*columns, **options)
    if posterior.counts.n_levels[0] < 2:
        return None
    theta, tails = posterior_draws(posterior), [(1 - interval) / 2, 0.5, (1 + interval) / 2]
    counts, shape = posterior.counts, posterior.shape
    centre, spread = counts.centre[0], counts.spread[0]
    u = ((np.log(places) if shape.on_log_levels else places) - centre) / spread
    low, median, high = np.quantile(np.exp(log_chances(shape, u, theta)[0]), tails, axis=0)
    thresholds = centre + spread * np.quantile(theta[:, THRESHOLD], tails)
    ends = np.exp(thresholds) if shape.on_log_levels else thresholds
    return CurveBand(places, low, median, high, tuple(ends.tolist()))


def posterior_draws(posterior: LogPosterior, n_draws: int = N_DRAWS) -> Array:
    """Return nodes (n_draws, 4) at equal steps of posterior mass."""
    prior, box = posterior.prior, find_box(posterior, find_mode(posterior))
    axes, mass = masses_in(posterior, box.low[0], box.high[0])
    cumulated = np.cumsum(mass.ravel(), dtype=np.float64)
    steps = (np.arange(n_draws) + 0.5) / n_draws
    chosen = np.searchsorted(cumulated, steps * cumulated[-1])
    places = np.unravel_index(chosen, mass.shape)
    return prior.tied(np.stack([axes[n][places[n]] for n in range(N_PARAMETERS)], axis=1))
