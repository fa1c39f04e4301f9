"""Fits of thresholds to counts: one fit, or thousands in one call.

Model, priors and the meaning of threshold and width are psignifit 4's (Schuett et al. 2016, Vision Research 122,
105-123). The status and the bound of an out-of-range threshold come from the binomial posterior.
"""

from __future__ import annotations  # lets `help` show ArrayLike instead of its expansion

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, TypedDict, Unpack

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments.require import below_1, between, expect, one_of, positive
from tactometry.psychometric import shape_named

from ..arrays import Array
from .counts import count_arrays, normalise
from .estimates import Fitting, ThresholdFit
from .log_posterior import LARGEST_RATE, LogPosterior, Prior
from .status import Status

METHODS = ("posterior", "likelihood")
ESTIMATES = ("mode", "median", "mean")
SHAPE = "normal"


class PriorOptions(TypedDict, total=False):
    """Options of the priors; the defaults are those of `Prior`."""

    guess_rate: float | None
    lapse_rate: float | None
    scale_free_width: bool
    lapse_beta: float
    guess_beta: float
    equal_asymptotes: bool
    narrowest_spacings: float


class Options(PriorOptions, total=False):
    """Options of `fit`; the defaults are those of `fitting`."""

    shape: str
    robust_range: bool
    method: str
    interval: float
    overdispersion: bool
    estimate: str


def fit(
    levels: ArrayLike,
    n_correct: ArrayLike,
    n_trials: ArrayLike,
    *,
    n_false_alarms: int = 0,
    n_catch: int = 0,
    **options: Unpack[Options],
) -> ThresholdFit:
    """Fit a psychometric function to the answers at each level.

    Parameters
    ----------
    levels, n_correct, n_trials : (n_levels,) array_like
        Levels in any unit and order, numbers of correct (or "yes") answers, and numbers of trials.
    n_false_alarms, n_catch : int
        "Yes" answers to catch trials, and number of catch trials. They inform a free guess rate.
    shape : str
        ``normal`` (the default), ``logistic``, ``gumbel``, ``reversed_gumbel`` or ``weibull`` (positive levels).
    guess_rate, lapse_rate : float or None
        Lower asymptote (1/m in forced choice), and distance of the upper asymptote from 1. None (the default) means
        free, with the priors Beta(1, `guess_beta`) and Beta(1, `lapse_beta`).
    equal_asymptotes : bool
        Whether both free rates are equal, with the prior of the lapse rate (psignifit 4's ``equalAsymptote``).
    method : str
        ``posterior`` (the default): the `estimate` of the posterior with a central interval. ``likelihood``: maximum
        likelihood without intervals, or the result of the posterior if the likelihood has no maximum.
    estimate : str
        ``mode`` (the default), ``median`` or ``mean``. The median replaces a mode outside its interval or on an edge of
        the priors. For answers that change in a single step, the mode is the middle of the step. In forced choice, mean
        and median are biased downwards.
    interval : float
        Coverage of the interval, between 0 and 1.
    scale_free_width : bool
        Whether the prior is flat in the log width (down to a twentieth of the range) rather than in the width.
    narrowest_spacings : float
        Smallest width, in smallest spacings of the levels. The prior decreases to 0 between twice this width and this
        width.
    robust_range : bool
        Whether the priors are based on the levels within Tukey's fences, as adaptive procedures start far from the
        threshold.
    overdispersion : bool
        Whether answers are beta-binomial, with overdispersion eta and its prior Beta(1, 10).

    Raises
    ------
    InvalidParameter
        For a value that is not a number, an impossible count (the error names the row), an unknown name, or a rate
        outside [0, 1).

    Examples
    --------
    >>> result = fit([1, 2, 3, 4, 5], [10, 11, 15, 19, 20], 20, shape="normal", guess_rate=0.5)
    >>> result.status.value, 2.5 < result.threshold < 3.5
    ('ok', True)
    >>> fit([1, 2, 3], [20, 20, 20], 20, guess_rate=0.5).threshold is None
    True
    """
    n_dimensions = np.ndim(levels)
    expect(n_dimensions <= 1, "levels", f"{n_dimensions} dimensions", "1; use fit_many for stacks of data sets")
    columns = (np.atleast_1d(np.asarray(values))[None] for values in (levels, n_correct, n_trials))
    return fit_many(*columns, n_false_alarms=[n_false_alarms], n_catch=[n_catch], **options)[0]


def fit_many(
    levels: ArrayLike,
    n_correct: ArrayLike,
    n_trials: ArrayLike,
    *,
    n_false_alarms: ArrayLike = 0,
    n_catch: ArrayLike = 0,
    **options: Unpack[Options],
) -> tuple[ThresholdFit, ...]:
    """Fit many data sets, stacked as (n_sets, n_levels), as `fit` does.

    Arguments broadcast; catch trials have the shape (n_sets,).

    Pad data sets of different lengths with levels of 0 trials.

    >>> [result.status.value for result in fit_many([1, 2, 3, 4], [[0, 0, 10, 10], [10] * 4], 10,
    ...     shape="logistic", guess_rate=0.0, lapse_rate=0.0)]
    ['separated', 'threshold_below_range']
    """
    return fitting(levels, n_correct, n_trials, n_false_alarms, n_catch, **options).results()


def fitting(
    levels: ArrayLike,
    n_correct: ArrayLike,
    n_trials: ArrayLike,
    n_false_alarms: ArrayLike = 0,
    n_catch: ArrayLike = 0,
    *,
    shape: str = SHAPE,
    robust_range: bool = False,
    method: str = "posterior",
    interval: float = 0.95,
    overdispersion: bool = False,
    estimate: str = "mode",
    **prior: Unpack[PriorOptions],
) -> Fitting:
    """Return data sets with priors and options for `fit_many`."""
    between("fit", 0, 1, interval=interval)
    one_of("method", method, METHODS)
    one_of("estimate", estimate, ESTIMATES)
    posterior = log_posterior(
        *(levels, n_correct, n_trials),
        shape=shape,
        n_false_alarms=n_false_alarms,
        n_catch=n_catch,
        robust_range=robust_range,
        **prior,
    )
    return Fitting(posterior, shape, method, interval, estimate, overdispersion)


def log_posterior(
    levels: ArrayLike,
    n_correct: ArrayLike,
    n_trials: ArrayLike,
    *,
    shape: str = SHAPE,
    n_false_alarms: ArrayLike = 0,
    n_catch: ArrayLike = 0,
    robust_range: bool = False,
    **options: Unpack[PriorOptions],
) -> LogPosterior:
    """Return the log posterior of the data sets of `fit_many`."""
    curve = shape_named(shape)
    arrays = count_arrays(levels, n_correct, n_trials, logarithms=curve.on_log_levels)
    counts = normalise(*arrays, robust_range=robust_range)
    alarms, catch = _catch_trials(n_false_alarms, n_catch, len(counts))
    known: dict[str, Any] = {"lapse_rate": None, "guess_rate": None, **options}
    prior = Prior(counts.gap, n_false_alarms=alarms, n_catch=catch, **known)
    check_rates("fit", prior.guess_rate, prior.lapse_rate)
    betas = {"lapse_beta": prior.lapse_beta, "guess_beta": prior.guess_beta}
    positive("fit", **betas, narrowest_spacings=prior.narrowest_spacings)
    if prior.equal_asymptotes:
        is_free = prior.guess_rate is None and prior.lapse_rate is None and not catch.any()
        stated = f"guess_rate {prior.guess_rate}, lapse_rate {prior.lapse_rate} and {catch.sum():g} catch trials"
        expected = "None, None and no catch trials, as equal rates are estimated from the answers alone"
        expect(is_free, "equal_asymptotes", stated, expected)
        prior = replace(prior, guess_beta=prior.lapse_beta)
    return LogPosterior(curve, counts, prior)


def check_rates(owner: str, guess_rate: float | None, lapse_rate: float | None) -> None:
    """Raise for rates that are out of range or leave no room to rise."""
    rates = {"guess_rate": guess_rate, "lapse_rate": lapse_rate}
    below_1(owner, **{name: rate for name, rate in rates.items() if rate is not None})
    # Known rates that sum to 1 leave no room to rise; free rates reach this only at the ends of their priors.
    highest = [LARGEST_RATE if rate is None else rate for rate in rates.values()]
    leaves_room = sum(highest) <= 1 and (guess_rate or 0) + (lapse_rate or 0) < 1
    expected = f"a sum below 1 (a free rate may reach {LARGEST_RATE:g})"
    expect(leaves_room, "guess_rate, lapse_rate", f"{guess_rate} and {lapse_rate}", expected)


def _catch_trials(n_false_alarms: ArrayLike, n_catch: ArrayLike, n_sets: int) -> tuple[Array, Array]:
    alarms, catch = (np.broadcast_to(np.asarray(n, dtype=np.float64), (n_sets,)) for n in (n_false_alarms, n_catch))
    for stated, counts in ((n_false_alarms, alarms), (n_catch, catch)):
        is_whole = ((counts >= 0) & (counts == np.floor(counts))).all()
        expect(is_whole, "n_false_alarms, n_catch", repr(stated), "whole numbers, 0 or more")
    expect((alarms <= catch).all(), "n_false_alarms", repr(n_false_alarms), f"at most n_catch, {n_catch!r}")
    return alarms, catch


__all__: Sequence[str] = ["METHODS", "Status", "ThresholdFit", "fit", "fit_many"]
