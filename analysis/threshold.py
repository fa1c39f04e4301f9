"""Thresholds from counts of answers: one fit, or thousands in one call, each with an interval and a
status."""

from __future__ import annotations  # so that `help` says ArrayLike, and not what it stands for

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ndtri

from tactometry.analysis import intervals
from tactometry.analysis.counts import Array, Bools, Counts, checked, normalised
from tactometry.analysis.likelihood import (
    LOG_WIDTH,
    THRESHOLD,
    log_likelihood,
    saturated_log_likelihood,
)
from tactometry.analysis.mode import Mode, find_mode
from tactometry.analysis.overdispersion import find_overdispersed_mode
from tactometry.analysis.prior import Prior
from tactometry.analysis.shared_grid import batched_marginals
from tactometry.analysis.status import NOTES, Status, proportion_interval, statuses
from tactometry.analysis.step import best_step
from tactometry.errors import InvalidParameter, nearest
from tactometry.psychometric import PsychometricFunction, Shape, shape_named

METHODS = ("ml", "map", "profile", "posterior", "bootstrap")
ON_LIKELIHOOD = ("ml", "profile")
OVERDISPERSED = ("ml", "map", "posterior")

WIDEST_SD = 2.0
"""In ranges of the levels: a likelihood this blunt has no threshold."""


@dataclass(frozen=True)
class ThresholdFit:
    """What the answers say about one threshold.

    `threshold` and the interval are in the unit of the levels (`width` too; for the shape ``weibull`` it is
    in natural logarithms of the level). None: the data do not tell. Where only a bound is known
    (`threshold_below_range`, `threshold_above_range`) the threshold is None and one end of the interval is
    the bound. `deviance` is that of the mode the method rests on (the likelihood's for ``ml`` and
    ``profile``, the posterior's otherwise). `note` is empty for the status ``ok``.
    """

    threshold: float | None
    width: float | None
    lapse_rate: float | None
    guess_rate: float | None
    overdispersion: float | None
    interval_low: float | None
    interval_high: float | None
    width_low: float | None
    width_high: float | None
    status: Status
    deviance: float | None
    n_trials: int
    n_levels: int
    shape: str
    method: str
    interval: float
    note: str

    @property
    def function(self) -> PsychometricFunction | None:
        """The fitted curve, or None where there is none."""
        if None in (self.threshold, self.width, self.lapse_rate, self.guess_rate):
            return None
        return PsychometricFunction(
            self.shape,
            self.threshold,  # type: ignore[arg-type]
            self.width,  # type: ignore[arg-type]
            self.guess_rate,  # type: ignore[arg-type]
            self.lapse_rate,  # type: ignore[arg-type]
        )


def fit(
    levels: ArrayLike,
    n_correct: ArrayLike,
    n_trials: ArrayLike,
    *,
    shape: str,
    guess_rate: float | None,
    lapse_rate: float | None = None,
    method: str = "posterior",
    interval: float = 0.95,
    n_false_alarms: int = 0,
    n_catch: int = 0,
    robust_range: bool = False,
    scale_free_width: bool = False,
    overdispersion: bool = False,
    n_resamples: int = 1000,
    rng: np.random.Generator | None = None,
) -> ThresholdFit:
    """Fit a psychometric function to the answers at each level.

    Parameters
    ----------
    levels, n_correct, n_trials : (n_levels,) array_like
        Levels in any unit and order, correct (or "yes") answers, trials. Rows without trials are ignored,
        equal levels are pooled.
    shape : str
        ``normal``, ``logistic``, ``gumbel``, ``reversed_gumbel`` or ``weibull`` (positive levels).
    guess_rate : float or None
        Lower asymptote: 1/m in forced choice; None to estimate it under its prior (yes/no).
    lapse_rate : float or None
        Distance of the upper asymptote from 1; None to estimate it under its prior, for every method.
    method : str
        ``ml`` maximum likelihood with Wald interval; ``profile`` the same with the profile likelihood's
        interval; ``map`` posterior mode with Laplace interval; ``posterior`` posterior mean with marginal
        central interval; ``bootstrap`` posterior mode with bias-corrected parametric bootstrap (needs `rng`).
    interval : float
        Coverage of the interval, between 0 and 1.
    n_false_alarms, n_catch : int
        "Yes" answers to catch trials, and catch trials: they bear on a free guess rate.
    scale_free_width : bool
        Whether the width's prior is flat in its logarithm (Jeffreys' for a scale) between psignifit's ends, instead of
        flat in the width: with few trials a flat prior lets wide functions pull the posterior mean of the threshold.
    robust_range : bool
        Whether the priors of threshold and width rest on the range of the levels within Tukey's fences
        instead of all. An adaptive procedure starts far from where it ends: its whole range says nothing
        about the function.
    overdispersion : bool
        Whether the answers are beta-binomial with overdispersion eta under its prior Beta(1, 10); for ``ml``,
        ``map`` (their intervals at the eta found) and ``posterior``. The status is that of the binomial.

    Returns
    -------
    ThresholdFit

    Raises
    ------
    InvalidParameter
        For what is no number, an impossible count (naming the row), an unknown name or a rate outside [0, 1).

    Notes
    -----
    Model, priors and the meaning of threshold and width are psignifit 4's (Schuett et al. 2016, Vision
    Research 122, 105-123). A bound of a threshold outside of the levels, and of the width of a step, is
    always the posterior's.

    Examples
    --------
    >>> found = fit([1, 2, 3, 4, 5], [10, 11, 15, 19, 20], 20, shape="normal", guess_rate=0.5)
    >>> found.status.value, 2.5 < found.threshold < 3.5
    ('ok', True)
    >>> fit([1, 2, 3], [20, 20, 20], 20, shape="normal", guess_rate=0.5).threshold is None
    True
    """
    x = np.asarray(levels)
    if x.ndim > 1:
        raise InvalidParameter(f"levels: found {x.ndim} dimensions, expected one; stacks of data sets go to fit_many")
    return fit_many(
        np.atleast_1d(x)[None],
        np.atleast_1d(np.asarray(n_correct))[None],
        np.atleast_1d(np.asarray(n_trials))[None],
        shape=shape,
        guess_rate=guess_rate,
        lapse_rate=lapse_rate,
        method=method,
        interval=interval,
        n_false_alarms=[n_false_alarms],
        n_catch=[n_catch],
        robust_range=robust_range,
        scale_free_width=scale_free_width,
        overdispersion=overdispersion,
        n_resamples=n_resamples,
        rng=rng,
    )[0]


def fit_many(
    levels: ArrayLike,
    n_correct: ArrayLike,
    n_trials: ArrayLike,
    *,
    shape: str,
    guess_rate: float | None,
    lapse_rate: float | None = None,
    method: str = "posterior",
    interval: float = 0.95,
    n_false_alarms: ArrayLike = 0,
    n_catch: ArrayLike = 0,
    robust_range: bool = False,
    scale_free_width: bool = False,
    overdispersion: bool = False,
    n_resamples: int = 1000,
    rng: np.random.Generator | None = None,
) -> tuple[ThresholdFit, ...]:
    """As `fit`, for stacks (n_sets, n_levels) of data sets, which broadcast; catch trials of shape (n_sets,).

    Sets of different length are filled up with rows of 0 trials.

    >>> [found.status.value for found in fit_many([1, 2, 3, 4], [[0, 0, 10, 10], [10] * 4], 10,
    ...     shape="logistic", guess_rate=0.0, lapse_rate=0.0, method="map")]
    ['separated', 'threshold_below_range']
    """
    curve = shape_named(shape)
    _check_options(guess_rate, lapse_rate, method, interval, rng)
    if overdispersion and method not in OVERDISPERSED:
        raise InvalidParameter(
            f"method: found {method!r} with overdispersion, expected one of {', '.join(OVERDISPERSED)}"
        )
    x, k, n = checked(levels, n_correct, n_trials, positive=curve.on_log_levels)
    if curve.on_log_levels:
        x = np.log(np.where(n > 0, x, 1.0))
    counts = normalised(x, k, n, robust_range=robust_range)
    alarms, catch = (_catch(v, len(counts)) for v in (n_false_alarms, n_catch))
    if (alarms > catch).any():
        raise InvalidParameter(f"n_false_alarms: found {n_false_alarms!r}, expected at most n_catch, {n_catch!r}")
    prior = Prior(counts.gap, lapse_rate, guess_rate, alarms, catch, scale_free_width=scale_free_width)
    return _Fitting(shape, curve, counts, prior, method, interval, overdispersion).results(n_resamples, rng)


def _check_options(
    guess_rate: float | None,
    lapse_rate: float | None,
    method: str,
    interval: float,
    rng: np.random.Generator | None,
) -> None:
    for name, rate in (("guess_rate", guess_rate), ("lapse_rate", lapse_rate)):
        if rate is not None and not 0 <= rate < 1:
            raise InvalidParameter(f"{name}: found {rate}, expected None or a number from 0 to below 1")
    largest = 0.5
    if (largest if guess_rate is None else guess_rate) + (largest if lapse_rate is None else lapse_rate) > 1 or (
        (guess_rate or 0) + (lapse_rate or 0) >= 1
    ):
        raise InvalidParameter(
            f"guess_rate, lapse_rate: found {guess_rate} and {lapse_rate}, expected a sum below 1 "
            "(a free rate may reach 0.5)"
        )
    if method not in METHODS:
        raise InvalidParameter(
            f"method: found {method!r}, expected one of {', '.join(METHODS)}{nearest(str(method), METHODS)}"
        )
    if not 0 < interval < 1:
        raise InvalidParameter(f"interval: found {interval}, expected a number between 0 and 1")
    if method == "bootstrap" and rng is None:
        raise InvalidParameter("rng: found None, expected a numpy.random.Generator for the method 'bootstrap'")


def _catch(values: ArrayLike, n_sets: int) -> Array:
    found = np.broadcast_to(np.asarray(values, dtype=np.float64), (n_sets,))
    if not ((found >= 0) & (found == np.floor(found))).all():
        raise InvalidParameter(f"n_false_alarms, n_catch: found {values!r}, expected whole numbers, 0 or more")
    return found


@dataclass(frozen=True)
class _Estimates:
    """theta (n_sets, 4) with the width in place of its logarithm; ends (n_sets, 2) of threshold and width."""

    theta: Array
    threshold: Array
    width: Array
    deviance: Array
    eta: Array | None


@dataclass(frozen=True)
class _Fitting:
    shape: str
    curve: Shape
    counts: Counts
    prior: Prior
    method: str
    interval: float
    overdispersed: bool

    def results(self, n_resamples: int, rng: np.random.Generator | None) -> tuple[ThresholdFit, ...]:
        mode = find_mode(self.curve, self.counts, self.prior)
        likeliest = find_mode(self.curve, self.counts, replace(self.prior, on_curve=False), mode.theta)
        step = best_step(self.curve, self.counts, likeliest)
        status = np.array(statuses(self.curve, self.counts, self.prior, mode, step), dtype=object)
        own = likeliest if self.method in ON_LIKELIHOOD else mode
        eta = None
        if self.overdispersed:
            free = replace(self.prior, on_curve=self.method not in ON_LIKELIHOOD)
            own, eta = find_overdispersed_mode(self.curve, self.counts, free)
        regular = own.interior & (own.threshold_sd < WIDEST_SD)
        lost = (status == Status.OK) & ~regular
        status[lost] = np.where(step.is_best[lost], Status.SEPARATED, Status.FLAT)
        regular &= np.isin(status, [Status.OK, Status.NON_MONOTONE, Status.TOO_FEW_LEVELS])
        estimates = self._estimates(own, eta)
        self._refine(estimates, own, regular, n_resamples, rng)
        self._integrate(estimates, own if self.method == "posterior" else mode, regular)
        if self.method in ON_LIKELIHOOD:
            stepped = status == Status.SEPARATED
            estimates.theta[stepped, THRESHOLD] = step.place[stepped]
        return tuple(self._result(i, Status(status[i]), estimates) for i in range(len(self.counts)))

    def _estimates(self, own: Mode, eta: Array | None) -> _Estimates:
        theta = own.theta.copy()
        theta[:, LOG_WIDTH] = np.exp(theta[:, LOG_WIDTH])
        deviance = 2 * (saturated_log_likelihood(self.counts) - log_likelihood(self.curve, self.counts, own.theta))
        z = float(ndtri((1 + self.interval) / 2)) * np.array([-1.0, 1.0])
        threshold = own.theta[:, [THRESHOLD]] + z * own.threshold_sd[:, None]
        log_width_sd = np.sqrt(own.covariance[:, LOG_WIDTH, LOG_WIDTH])[:, None]
        with np.errstate(over="ignore"):
            width = np.exp(own.theta[:, [LOG_WIDTH]] + z * log_width_sd)
        return _Estimates(theta, threshold, width, np.maximum(deviance, 0.0), eta)

    def _refine(
        self,
        estimates: _Estimates,
        own: Mode,
        regular: Bools,
        n_resamples: int,
        rng: np.random.Generator | None,
    ) -> None:
        """Put in the intervals that cost more than a Hessian."""
        chosen = np.flatnonzero(regular)
        if self.method not in ("profile", "bootstrap") or not len(chosen):
            return
        sets, prior, part = self.counts[chosen], self.prior[chosen], own[chosen]
        if rng is not None and self.method == "bootstrap":
            found = intervals.bootstrap(self.curve, sets, prior, part, self.interval, n_resamples, rng)
        else:
            free = replace(prior, on_curve=False)
            found = intervals.profile(self.curve, sets, free, part, self.interval)
        estimates.threshold[chosen] = found

    def _integrate(self, estimates: _Estimates, mode: Mode, regular: Bools) -> None:
        """Put in the posterior's intervals: for its own method, and wherever another has none."""
        wanted = np.ones(len(self.counts), dtype=bool) if self.method == "posterior" else ~regular
        chosen = np.flatnonzero(wanted & (self.counts.n_levels > 1))
        sets, prior = self.counts[chosen], self.prior[chosen]
        if estimates.eta is not None and self.method == "posterior":
            prior = replace(prior, overdispersion=estimates.eta[chosen])
        found = batched_marginals(self.curve, sets, prior, mode[chosen], self.interval)
        estimates.threshold[chosen], estimates.width[chosen] = found.threshold, found.width
        if self.method == "posterior":
            estimates.theta[chosen] = found.mean
            if estimates.eta is not None:
                estimates.eta[chosen] = found.overdispersion

    def _result(self, i: int, status: Status, estimates: _Estimates) -> ThresholdFit:
        told = self._told(i, status, estimates)
        low, high = (self._level(i, end) for end in estimates.threshold[i])
        narrow, wide = (float(end * self.counts.spread[i]) for end in estimates.width[i])
        m, width, lapse, guess = estimates.theta[i]
        has_ends = told or status in (Status.BELOW, Status.ABOVE)
        return ThresholdFit(
            threshold=self._level(i, m) if told else None,
            width=float(width * self.counts.spread[i]) if told and status != Status.SEPARATED else None,
            lapse_rate=float(lapse) if told else None,
            guess_rate=float(guess) if told else None,
            overdispersion=float(estimates.eta[i]) if told and estimates.eta is not None else None,
            interval_low=low if has_ends and status != Status.BELOW else None,
            interval_high=high if has_ends and status != Status.ABOVE else None,
            width_low=narrow if told and status != Status.SEPARATED else None,
            width_high=wide if told and np.isfinite(wide) else None,
            status=status,
            deviance=float(estimates.deviance[i]) if told else None,
            n_trials=int(self.counts.n_trials[i].sum()),
            n_levels=int(self.counts.n_levels[i]),
            shape=self.shape,
            method=self.method,
            interval=self.interval,
            note=self._note(i, status),
        )

    def _told(self, i: int, status: Status, estimates: _Estimates) -> bool:
        if status in (Status.OK, Status.SEPARATED):
            return True
        inside = abs(float(estimates.theta[i, THRESHOLD])) <= 0.5
        return inside and (
            status == Status.NON_MONOTONE or (status == Status.TOO_FEW_LEVELS and bool(self.counts.n_levels[i] > 1))
        )

    def _level(self, i: int, u: float) -> float | None:
        level = float(self.counts.centre[i] + self.counts.spread[i] * u)
        if self.curve.on_log_levels:
            with np.errstate(over="ignore"):
                level = float(np.exp(level))
        return level if np.isfinite(level) else None

    def _note(self, i: int, status: Status) -> str:
        if status == Status.TOO_FEW_LEVELS and self.counts.n_levels[i] == 1:
            k, n = self.counts.n_yes[i].sum(), self.counts.n_trials[i].sum()
            low, high = proportion_interval(k, n, self.interval)
            return f"one level only: {k:.0f} of {n:.0f} answers, a rate from {low:.3f} to {high:.3f}; no threshold"
        return NOTES[status]


__all__: Sequence[str] = ["METHODS", "Status", "ThresholdFit", "fit", "fit_many"]
