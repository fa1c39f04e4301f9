"""Fast posterior modes of many tracks, equal to those of `fit`."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments.require import expect
from tactometry.psychometric import shape_named

from ..arrays import Array, Bools, Rows
from .counts import totals
from .estimates import is_regular
from .fitting import log_posterior
from .likelihood import LOG_WIDTH, THRESHOLD
from .mode import find_mode

MOST_SHARED = 64
"""Largest number of levels for which tracks are counted on common levels; QUEST uses arbitrary levels."""


@dataclass(frozen=True)
class TrackModes(Rows):
    """Threshold, standard error and width of each track, shape (n_sets,).

    `regular` is True if the curvature is well conditioned.
    """

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
    """Find the mode of each track's posterior.

    Raises `InvalidParameter` if a rate is out of range, arrays do not match, or an answer is neither 1 nor 0.

    - `levels`, `answers`: The level of each trial and its answer, 1 or 0. Trials with the level NaN are ignored.
    - `shape`, `guess_rate`, `lapse_rate`, `scale_free_width`: As for `tactometry.analysis.threshold.fitting.fit`. The
      shape must use levels, not their logarithms.

    >>> x = np.tile([10.0, 14.0, 18.0, 22.0, 26.0], (1, 8))
    >>> result = fit_modes(x, x > [[16.0] * 20 + [20.0] * 20], shape="normal", guess_rate=0.0, lapse_rate=0.02)
    >>> result.thresholds.round().tolist(), result.regular.tolist()
    ([18.0], [True])
    """
    x, y = np.asarray(levels, dtype=np.float64), np.asarray(answers, dtype=np.float64)
    shapes = f"shapes {x.shape}, {y.shape}"
    expect(x.ndim == 2 and x.shape == y.shape, "fit_modes", shapes, "two arrays of shape (n_sets, n_trials)")
    expect(not shape_named(shape).on_log_levels, "fit_modes.shape", shape, "a shape that uses levels, not logarithms")
    used = ~np.isnan(x)
    expect(np.isin(y[used], (0, 1)).all(), "fit_modes.answers", "another value", "1 or 0")
    shared = np.unique(x[used])
    is_shared = 2 <= len(shared) <= MOST_SHARED
    columns = _pooled(shared, x, y, used) if is_shared else (np.where(used, x, 0.0), np.where(used, y, 0.0), used)
    posterior = log_posterior(
        *columns, shape=shape, guess_rate=guess_rate, lapse_rate=lapse_rate, scale_free_width=scale_free_width
    )
    counts, mode = posterior.counts, find_mode(posterior)
    at = counts.centre + counts.spread * mode.theta[:, THRESHOLD]
    widths = counts.spread * np.exp(mode.theta[:, LOG_WIDTH])
    return TrackModes(at, counts.spread * mode.sd[:, THRESHOLD], widths, is_regular(mode) & (counts.n_levels > 1))


def _pooled(shared: Array, x: Array, y: Array, used: Bools) -> tuple[Array, Array, Array]:
    """Count answers at common levels."""
    shape = (len(x), len(shared))
    cells = (np.arange(len(x))[:, None] * shape[1] + np.searchsorted(shared, x))[used]
    return shared[None], totals(cells, y[used], shape), totals(cells, np.ones(len(cells)), shape)
