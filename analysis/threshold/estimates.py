"""Results of fits of many data sets, in the unit of the levels."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tactometry.psychometric import PsychometricFunction

from ..arrays import Array, Bools, Rows
from .likelihood import LOG_WIDTH, THRESHOLD
from .log_posterior import LogPosterior
from .mode import Mode, find_mode, find_overdispersed_mode
from .posterior import Marginals
from .shared_grid import batched_marginals
from .status import HELD, Status, Statuses, best_step, notes, statuses, verdict_shares

CENSORED = (Status.BELOW, Status.ABOVE)
WITH_THRESHOLD = (Status.OK, Status.SEPARATED)
FITTED_ANYWAY = (Status.NON_MONOTONE, Status.TOO_FEW_LEVELS)
WIDEST_SD = 0.5
"""Largest SD of a threshold, in ranges of the levels; above it the 95 % interval exceeds all levels."""
WIDEST_LOG_SD = 1.5
"""Largest SD of a log width; its interval extends from a twentieth to twenty times the width."""


@dataclass(frozen=True)
class ThresholdFit:
    """Estimates of one threshold.

    `threshold` and the interval are in the unit of the levels (`width` too; for the shape ``weibull`` it is
    in natural logarithms of the level). None means that the data do not determine the value. If only a bound is known
    (`threshold_below_range`, `threshold_above_range`) the threshold is None and one end of the interval is
    the bound. If the threshold is missing for another reason, such as `flat`, the interval is that of the posterior. An
    end is then None if the probability that the threshold lies beyond the levels on this side is above 0.2. `deviance`
    is evaluated at the mode of the posterior or likelihood. `note` explains a status and is empty for ``ok``.

    `method` is also ``posterior`` if the likelihood was requested but has no maximum, for example if the answers change
    in a single step. A maximum of the likelihood has no interval.

    `threshold_mode`, `threshold_median` and `threshold_mean` are those of the posterior for every method. With
    overdispersion they and the interval refer to the beta-binomial posterior. `probability_below`, `probability_within`
    and `probability_above` are the posterior probabilities that determine the status (None for fewer than two levels).
    In turn: all levels are on the upper asymptote, the levels cover part of the rise of the function, or all levels are
    on the lower asymptote.

    For a comparison (`equality.fit_comparisons`) `threshold` is the point of subjective equality, where half of all
    answers are "more". `middle` is the midpoint of the curve between its asymptotes, and `jnd` the distance from the
    point of subjective equality to 75 % "more".
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
    threshold_mode: float | None = None
    threshold_median: float | None = None
    threshold_mean: float | None = None
    probability_below: float | None = None
    probability_within: float | None = None
    probability_above: float | None = None
    middle: float | None = None
    jnd: float | None = None
    jnd_low: float | None = None
    jnd_high: float | None = None

    @property
    def function(self) -> PsychometricFunction | None:
        """Fitted function, or None if one of its parameters is missing."""
        if None in (self.threshold, self.width, self.lapse_rate, self.guess_rate):
            return None
        return PsychometricFunction(
            self.shape,
            self.threshold if self.middle is None else self.middle,  # type: ignore[arg-type]
            self.width,  # type: ignore[arg-type]
            self.guess_rate,  # type: ignore[arg-type]
            self.lapse_rate,  # type: ignore[arg-type]
        )


@dataclass(frozen=True)
class Estimates(Rows):
    """Parameters of many fits, with the ends of their intervals.

    Parameters (n_sets, 4) contain the width itself, not its logarithm. Ends (n_sets, 2) belong to threshold and width.
    `method` (n_sets,) names the source of the ends.
    """

    theta: Array
    threshold: Array
    width: Array
    method: NDArray[np.object_]


@dataclass(frozen=True)
class Fitting:
    """Data sets with their priors and the options of their fits."""

    posterior: LogPosterior
    shape: str
    method: str
    interval: float
    estimate: str
    overdispersed: bool

    @cached_property
    def mode(self) -> Mode:
        """Mode of the binomial posterior."""
        return find_mode(self.posterior)

    @cached_property
    def marginals(self) -> Marginals:
        """Marginals of the binomial posterior, which determine the statuses."""
        return self._integrated(self.posterior, self.mode)

    def results(self) -> tuple[ThresholdFit, ...]:
        posterior = self.posterior
        likeliest = find_mode(posterior.under(on_curve=False), self.mode.theta)
        step = best_step(posterior, likeliest)
        shares = verdict_shares(posterior, self.marginals)
        status = np.array(statuses(posterior, shares, step), dtype=object)

        basis, marginals, eta = self.mode, self.marginals, None
        if self.overdispersed:
            basis, eta = find_overdispersed_mode(posterior)
            marginals = self._integrated(posterior.under(overdispersion=eta), basis)
            eta = marginals.overdispersion if self.estimate == "mean" else eta
        levels = np.stack([basis.theta[:, THRESHOLD], marginals.threshold[:, 1], marginals.mean[:, THRESHOLD]])
        place = np.where(step.is_between, step.place, np.nan)
        estimates = self._of_posterior(basis, marginals, place)

        if self.method == "likelihood":
            basis = likeliest
            if self.overdispersed:
                basis, eta = find_overdispersed_mode(posterior.under(on_curve=False))
            has_maximum = is_regular(basis) & np.isin(status, (Status.OK, *FITTED_ANYWAY))
            of_step = np.where(step.is_best, Status.SEPARATED, Status.FLAT)
            status = np.where((status == Status.OK) & ~has_maximum, of_step, status)
            estimates = _of_likelihood(basis).where(has_maximum, estimates)
            is_step = (status == Status.SEPARATED) & _within(step.place, estimates.threshold)
            estimates.theta[is_step, THRESHOLD] = step.place[is_step]

        # rounding may make the deviance of a perfect fit negative
        deviance = np.maximum(posterior.deviance(basis.theta), 0.0)
        return self._fits(status, estimates, shares, levels, deviance, eta)

    def _integrated(self, posterior: LogPosterior, mode: Mode) -> Marginals:
        """Integrate the posterior of every data set with at least two levels."""
        chosen = np.flatnonzero(posterior.counts.n_levels > 1)
        result = batched_marginals(posterior[chosen], mode[chosen], self.interval)
        return Marginals.empty(len(posterior)).replaced(chosen, result)

    def _of_posterior(self, mode: Mode, marginals: Marginals, place: Array) -> Estimates:
        """Return the mode, median or mean of the posterior.

        For a step, all thresholds within a range are modes; `place` is the middle of this range. The median replaces a
        mode on an edge of the priors or outside its interval.
        """
        threshold, width = marginals.threshold[:, [0, 2]], marginals.width[:, [0, 2]]
        theta = marginals.mean
        if self.estimate != "mean":
            theta = marginals.mean.copy()
            theta[:, THRESHOLD], theta[:, LOG_WIDTH] = marginals.threshold[:, 1], marginals.width[:, 1]
        if self.estimate == "mode":
            top, is_step = _with_width(mode.theta), ~np.isnan(place)
            top[is_step, THRESHOLD] = place[is_step]
            holds_width = _within(top[:, LOG_WIDTH], width)
            top[:, LOG_WIDTH] = np.where(holds_width, top[:, LOG_WIDTH], theta[:, LOG_WIDTH])
            is_summit = is_step | (mode.interior & holds_width)
            is_held = is_summit & _within(top[:, THRESHOLD], threshold)
            theta = np.where(is_held[:, None], top, theta)
        return Estimates(theta, threshold, width, np.full(len(theta), "posterior", dtype=object))

    def _fits(
        self,
        status: Statuses,
        estimates: Estimates,
        shares: Array,
        levels: Array,
        deviance: Array,
        eta: Array | None,
    ) -> tuple[ThresholdFit, ...]:
        """Return the result of each data set, with None for undetermined values."""
        counts, (threshold, width, lapse, guess) = self.posterior.counts, estimates.theta.T
        has_curve = counts.n_levels > 1
        is_fitted_anyway = np.isin(status, FITTED_ANYWAY) & has_curve & (np.abs(threshold) <= 0.5)
        has_threshold = np.isin(status, WITH_THRESHOLD) | is_fitted_anyway
        has_width = has_threshold & (status != Status.SEPARATED)  # a step determines only an upper bound of the width
        has_low, has_high = _has_ends(status, shares, has_threshold).T & has_curve
        low, high = self._levels(estimates.threshold.T)
        narrow, wide = counts.spread * estimates.width.T

        columns = {
            "threshold": _known(self._levels(threshold), has_threshold),
            "width": _known(counts.spread * width, has_width),
            "lapse_rate": _known(lapse, has_threshold),
            "guess_rate": _known(guess, has_threshold),
            "interval_low": _known(low, has_low),
            "interval_high": _known(high, has_high),
            "width_low": _known(narrow, has_width),
            "width_high": _known(wide, has_threshold),
            "deviance": _known(deviance, has_threshold),
            "overdispersion": [None] * len(status) if eta is None else _known(eta, has_threshold),
            "method": np.where(has_low | has_high, estimates.method, self.method).tolist(),
            "status": [Status(word) for word in status],
            "note": notes(counts, status, self.interval),
            "n_trials": counts.n_trials.sum(axis=1).astype(int).tolist(),
            "n_levels": counts.n_levels.tolist(),
        }
        for name, u in zip(("mode", "median", "mean"), self._levels(levels), strict=True):
            columns[f"threshold_{name}"] = _known(u, has_threshold)
        for name, share in zip(("within", "below", "above"), shares.T[:3], strict=True):
            columns[f"probability_{name}"] = _known(share, has_curve)
        rows = (dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True))
        return tuple(ThresholdFit(**row, shape=self.shape, interval=self.interval) for row in rows)

    def _levels(self, u: Array) -> Array:
        counts = self.posterior.counts
        levels = counts.centre + counts.spread * u
        with np.errstate(over="ignore"):
            return np.exp(levels) if self.posterior.shape.on_log_levels else levels


def _of_likelihood(mode: Mode) -> Estimates:
    """Return the maximum-likelihood estimates, without intervals."""
    open_ends = np.full((len(mode.theta), 2), np.nan)
    return Estimates(_with_width(mode.theta), open_ends, open_ends, np.full(len(open_ends), "likelihood", dtype=object))


def _has_ends(status: Statuses, shares: Array, has_threshold: Bools) -> Bools:
    """Return True for each end (n_sets, 2) of an interval that is known.

    Without a threshold, an end is unknown unless the answers exclude a threshold beyond the levels on this side. Both
    ends are known for `ok`.
    """
    is_open = ~has_threshold[:, None] & (shares[:, 1:3] > 1 - HELD)
    is_bound = np.isin(status, CENSORED)
    is_open[is_bound] = status[is_bound, None] == np.array(CENSORED, dtype=object)
    return np.asarray(~is_open)


def _known(values: Array, where: Bools) -> list[float | None]:
    """Return a list of values, with None for unknown or infinite ones."""
    is_known = where & np.isfinite(values)
    return [value if known else None for value, known in zip(values.tolist(), is_known, strict=True)]


def is_regular(mode: Mode) -> Bools:
    """Return True where the curvature at a mode is well conditioned."""
    is_narrow = (mode.sd[:, THRESHOLD] < WIDEST_SD) & (mode.sd[:, LOG_WIDTH] < WIDEST_LOG_SD)
    return np.asarray(mode.interior & is_narrow)


def _with_width(theta: Array) -> Array:
    """Return the parameters with the width instead of its logarithm."""
    theta = theta.copy()
    with np.errstate(over="ignore"):
        theta[:, LOG_WIDTH] = np.exp(theta[:, LOG_WIDTH])
    return theta


def _within(x: Array, ends: Array) -> Bools:
    return np.asarray((ends[:, 0] <= x) & (x <= ends[:, 1]))
