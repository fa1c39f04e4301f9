"""Intervals of a threshold by profile likelihood and by parametric bootstrap."""

from dataclasses import replace

import numpy as np
from scipy.special import ndtr, ndtri
from scipy.stats import chi2

from tactometry.psychometric import Shape

from ..arrays import Array, Bools
from .counts import Counts
from .likelihood import GUESS, THRESHOLD, log_chances
from .mode import Mode, climb
from .prior import Prior

MAX_BISECTIONS = 60
FARTHEST = 16.0
"""In ranges of the levels: a profile that has not fallen until there has no end."""
SAME = 1e-9
"""The same answers drawn again may be fitted that far off."""


def profile(shape: Shape, counts: Counts, prior: Prior, mode: Mode, interval: float) -> Array:
    """Where the log-likelihood, maximised over all but the threshold, is chi2(interval)/2 below its maximum.

    Shape (n_sets, 2), on the scale of `Counts.u`; infinite where the profile has no end on that side.
    """
    floor = mode.log_density - chi2.ppf(interval, 1) / 2
    sides = [_profile_end(shape, counts, prior, mode, floor, side) for side in (-1.0, 1.0)]
    return np.stack(sides, axis=1)


def _profile_end(shape: Shape, counts: Counts, prior: Prior, mode: Mode, floor: Array, side: float) -> Array:
    inner = mode.theta[:, THRESHOLD].copy()
    reach = np.maximum(2 * mode.threshold_sd, 1e-3)
    outer, start = inner + side * reach, mode.theta
    for _ in range(MAX_BISECTIONS):
        above, start = _is_above(shape, counts, prior, outer, start, floor)
        if not (above & (np.abs(outer) < FARTHEST)).any():
            break
        inner, outer = np.where(above, outer, inner), np.where(above, outer + side * reach, outer)
        reach = 2 * reach
    endless = above
    # Every climb begins where the last one ended: neighbouring thresholds have neighbouring summits.
    for _ in range(MAX_BISECTIONS):
        middle = (inner + outer) / 2
        above, start = _is_above(shape, counts, prior, middle, start, floor)
        inner, outer = np.where(above, middle, inner), np.where(above, outer, middle)
        if (np.abs(outer - inner) <= 1e-9 * np.maximum(mode.threshold_sd, 1e-9)).all():
            break
    return np.where(endless, side * np.inf, (inner + outer) / 2)


def _is_above(
    shape: Shape, counts: Counts, prior: Prior, threshold: Array, start: Array, floor: Array
) -> tuple[Bools, Array]:
    at_threshold = climb(shape, counts, replace(prior, threshold=threshold), start)
    return at_threshold.log_density > floor, at_threshold.theta


def bootstrap(
    shape: Shape,
    counts: Counts,
    prior: Prior,
    mode: Mode,
    interval: float,
    n_resamples: int,
    rng: np.random.Generator,
) -> Array:
    """Bias-corrected percentiles of the mode's threshold over answers drawn from the fitted function.

    Shape (n_sets, 2), on the scale of `Counts.u` (Efron 1981, bias-corrected percentile method).
    """
    ends = []
    for i, theta in enumerate(mode.theta):
        here = slice(i, i + 1)
        ends.append(_bootstrap_one(shape, counts[here], prior[here], theta, interval, n_resamples, rng))
    return np.stack(ends)


def _bootstrap_one(
    shape: Shape,
    counts: Counts,
    prior: Prior,
    theta: Array,
    interval: float,
    n_resamples: int,
    rng: np.random.Generator,
) -> Array:
    same = np.zeros(n_resamples, dtype=np.int64)
    chance = np.exp(log_chances(shape, counts.u[0], theta)[0])
    drawn = rng.binomial(counts.n_trials[0].astype(np.int64), np.minimum(chance, 1.0), (n_resamples, len(chance)))
    # Catch trials are answers too: what is known of a free guess rate varies with them.
    alarms = rng.binomial(int(prior.n_catch[0]), theta[GUESS], n_resamples).astype(np.float64)
    resampled = counts[same].with_yes(drawn.astype(np.float64))
    start = np.broadcast_to(theta, (n_resamples, len(theta)))
    refits = climb(shape, resampled, replace(prior[same], n_false_alarms=alarms), start).theta[:, THRESHOLD]
    away = refits - theta[THRESHOLD]
    n_below = np.sum(away < -SAME) + 0.5 * np.sum(np.abs(away) <= SAME)
    # Half a draw more on each side keeps the bias finite where all draws lie on one side.
    bias = ndtri((n_below + 0.5) / (n_resamples + 1))
    tails = ndtri((1 + interval * np.array([-1.0, 1.0])) / 2)
    return np.asarray(np.quantile(refits, ndtr(2 * bias + tails)))
