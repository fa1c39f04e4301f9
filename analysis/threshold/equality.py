"""PSE and just noticeable difference of comparisons."""

from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ndtri

from ..arrays import Array
from .estimates import Fitting, ThresholdFit
from .fitting import fitting
from .likelihood import GUESS, LAPSE, LOG_WIDTH, THRESHOLD
from .log_posterior import LogPosterior
from .posterior import find_box, masses_in
from .status import Status

EQUAL, NOTICED = 0.5, 0.75
"""Rates of "more" at the point of subjective equality and one just noticeable difference above it."""
BINS_PER_STEP = 16
"""Number of histogram bins per step of the posterior's grid."""
WIDEST_STEPS = 400
"""Largest distance from the mean, in steps of the grid; values beyond are clipped to it."""
UNKNOWN = (
    *("threshold", "threshold_mode", "threshold_median", "threshold_mean", "width", "width_low", "width_high"),
    *("guess_rate", "lapse_rate", "deviance", "interval_low", "interval_high"),
)
"""Fields without a value if the point of equality is out of range."""


@dataclass(frozen=True)
class Equality:
    """Lower end, median and upper end of PSE and JND."""

    pse: tuple[float, float, float]
    jnd: tuple[float, float, float]


def fit_comparisons(
    levels: ArrayLike, n_more: ArrayLike, n_trials: ArrayLike, *, interval: float = 0.95, **options: Any
) -> tuple[ThresholdFit, ...]:
    """Fit comparisons; return PSEs and just noticeable differences.

    >>> (pse,) = fit_comparisons([36, 38, 40, 42, 44], [1, 3, 10, 17, 19], 20, guess_rate=None, scale_free_width=True)
    >>> 39.5 < pse.threshold < 40.5, 1 < pse.jnd < 3
    (True, True)
    """
    fitted = fitting(levels, n_more, n_trials, interval=interval, **options)
    counts = fitted.posterior.counts
    lowest, highest = (counts.centre + side * counts.spread / 2 for side in (-1, 1))
    result = zip(fitted.results(), equalities(fitted), lowest.tolist(), highest.tolist(), strict=True)
    return tuple(_compared(*one) for one in result)


def _compared(fit: ThresholdFit, equality: Equality | None, lowest: float, highest: float) -> ThresholdFit:
    """Replace the midpoint of the curve by the point of equality or its bound."""
    if equality is None:
        return fit
    (low, pse, high), (narrow, jnd, wide) = equality.pse, equality.jnd
    if fit.threshold is None:
        ends: dict[str, Any] = {"interval_low": low, "interval_high": high}
        return replace(fit, **{name: end for name, end in ends.items() if getattr(fit, name) is not None})
    if not lowest <= pse <= highest:
        end = {"interval_high": high} if pse < lowest else {"interval_low": low}
        status = Status.BELOW if pse < lowest else Status.ABOVE
        return replace(fit, **dict.fromkeys(UNKNOWN) | end, status=status, note=status.note)  # type: ignore[arg-type]
    return replace(
        fit,
        threshold=pse,
        interval_low=low,
        interval_high=high,
        threshold_mode=None,
        threshold_median=pse,
        threshold_mean=None,
        middle=fit.threshold,
        jnd=None if fit.width is None else jnd,
        jnd_low=None if fit.width is None else narrow,
        jnd_high=None if fit.width_high is None else wide,
    )


def equalities(fitted: Fitting) -> list[Equality | None]:
    """Return PSE and JND of each data set, None with fewer than two levels.

    The PSE is defined by the rate of all answers, not by the part between the asymptotes: a standard compared with
    itself is called "more" in half of the trials, even if it is often not felt. The shape is the cumulative normal.
    """
    posterior, boxes = fitted.posterior, fitted.marginals
    result: list[Equality | None] = []
    for n, n_levels in enumerate(posterior.counts.n_levels.tolist()):
        one, low, high = posterior[n : n + 1], boxes.low[n], boxes.high[n]
        if n_levels > 1 and np.isnan(low).any():  # the data set was computed on a shared grid
            box = find_box(one, fitted.mode[n : n + 1])
            low, high = box.low[0], box.high[0]
        result.append(_equality(one, low, high, fitted.interval) if n_levels > 1 else None)
    return result


def _equality(posterior: LogPosterior, low: Array, high: Array, interval: float) -> Equality:
    axes, mass = masses_in(posterior, low, high)
    lapse, guess = axes[LAPSE][:, None], axes[GUESS]
    # Position of each rate on the normal curve, in standard deviations from its midpoint.
    shares = ((rate - guess) / (1 - guess - lapse) for rate in (EQUAL, NOTICED))
    equal, noticed = (ndtri(np.clip(share, 1e-9, 1 - 1e-9)) for share in shares)
    per_sd = np.exp(axes[LOG_WIDTH])[:, None, None] / posterior.shape.z_width
    threshold = axes[THRESHOLD][:, None, None, None] + per_sd * equal
    log_difference = np.log(per_sd * (noticed - equal))
    quantiles = partial(_quantiles, interval=interval)
    pse = quantiles(threshold, mass, axes[THRESHOLD][1] - axes[THRESHOLD][0])
    jnd = quantiles(log_difference, mass.sum(axis=0), axes[LOG_WIDTH][1] - axes[LOG_WIDTH][0])
    centre, spread = posterior.counts.centre[0], posterior.counts.spread[0]
    return Equality(tuple((centre + spread * pse).tolist()), tuple((spread * np.exp(jnd)).tolist()))


def _quantiles(values: Array, mass: Array, step: float, *, interval: float) -> Array:
    """Return the lower end, median and upper end of weighted values."""
    flat, weights = np.broadcast_to(values, mass.shape).ravel(), mass.ravel()
    middle = float((flat * weights).sum() / weights.sum())
    reach = WIDEST_STEPS * step
    places = np.clip((flat - middle + reach) / step, 0, 2 * WIDEST_STEPS) * BINS_PER_STEP
    size = 2 * WIDEST_STEPS * BINS_PER_STEP + 1
    counts = np.bincount(np.rint(places).astype(np.int64), weights, size)
    smooth = np.convolve(counts, np.full(BINS_PER_STEP, 1 / BINS_PER_STEP), mode="full")
    cumulated = np.cumsum(smooth) / smooth.sum()
    shares = [(1 - interval) / 2, 0.5, (1 + interval) / 2]
    # Cumulated mass refers to the upper edges of bins; smoothing shifts it by half a step.
    result = np.interp(shares, cumulated, np.arange(len(cumulated)) + 0.5) - (BINS_PER_STEP - 1) / 2
    return np.asarray(result * step / BINS_PER_STEP - reach + middle)
