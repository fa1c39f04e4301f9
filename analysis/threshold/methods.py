"""The fits of many data sets by one method: statuses from the data, numbers from the method, and where it has none (no
curvature at its mode, a step, a bound) from the posterior.

Intervals of a threshold by profile likelihood and by parametric bootstrap.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri
from scipy.stats import chi2

from tactometry.psychometric import Shape

from ..arrays import Array, Bools, Indices
from .counts import Counts
from .likelihood import GUESS, LOG_WIDTH, THRESHOLD, log_chances, log_likelihood, saturated_log_likelihood
from .mode import Mode, climb, find_mode, find_overdispersed_mode
from .posterior import Marginals
from .prior import Prior
from .result import ThresholdFit
from .shared_grid import batched_marginals
from .status import (
    AFTER_A_TRACK,
    TOO_NARROW,
    Status,
    StepFit,
    best_step,
    proportion_interval,
    stand_as_after_a_track,
    statuses,
    verdict_shares,
)

Statuses = NDArray[np.object_]
ON_LIKELIHOOD = ("ml", "profile")
CENSORED = (Status.BELOW, Status.ABOVE)
WITH_THRESHOLD = (Status.OK, Status.SEPARATED)
FITTED_ANYWAY = (Status.NON_MONOTONE, Status.TOO_FEW_LEVELS)
WIDEST_SD = 0.5
"""In ranges of the levels: the 95 % interval of a threshold with a larger standard error exceeds all levels, and a
curvature so weak is none to rest on."""
WIDEST_LOG_SD = 1.5
"""Of the logarithm of a width: an interval from a twentieth to twenty times the width says nothing."""
MAX_BISECTIONS = 60
FARTHEST = 16.0
"""In ranges of the levels: a profile that has not fallen until there has no end."""
SAME = 1e-9
"""The same answers drawn again may be fitted that far off."""


@dataclass(frozen=True)
class PointEstimate:
    """Estimates (n_sets, 4) with the width in place of its logarithm; ends (n_sets, 2) of threshold and width; the
    overdispersion (n_sets,) or None."""

    theta: Array
    threshold: Array
    width: Array
    eta: Array | None

    def where(self, chosen: Bools, other: "PointEstimate") -> "PointEstimate":
        """This one, and another in some sets."""
        pairs = ((self.theta, other.theta), (self.threshold, other.threshold), (self.width, other.width))
        theta, threshold, width = (np.where(chosen[:, None], theirs, ours) for ours, theirs in pairs)
        return PointEstimate(theta, threshold, width, self.eta)


@dataclass(frozen=True)
class Fitting:
    """Data sets with what is known before them, and how they are fitted."""

    shape: str
    curve: Shape
    counts: Counts
    prior: Prior
    method: str
    interval: float
    estimate: str
    overdispersed: bool

    def results(self, n_resamples: int, rng: np.random.Generator | None) -> tuple[ThresholdFit, ...]:
        mode = find_mode(self.curve, self.counts, self.prior)
        likeliest = find_mode(self.curve, self.counts, replace(self.prior, on_curve=False), mode.theta)
        step = best_step(self.curve, self.counts, likeliest)
        binomial = self._marginals(mode)
        shares = verdict_shares(self.counts, self.prior, binomial)
        status = np.array(statuses(self.counts, self.prior, shares, step), dtype=object)
        basis, eta = likeliest if self.method in ON_LIKELIHOOD else mode, None
        if self.overdispersed:
            free = replace(self.prior, on_curve=self.method not in ON_LIKELIHOOD)
            basis, eta = find_overdispersed_mode(self.curve, self.counts, free)
        point = self._of_posterior(mode, binomial, step)
        if self.method == "posterior":
            if eta is not None:
                point = self._of_posterior(basis, self._marginals(basis, eta), step, eta)
        else:
            rests = is_regular(basis) & np.isin(status, (Status.OK, *FITTED_ANYWAY))
            curved = self._of_curvature(basis, eta, rests, n_resamples, rng)
            # A profile may never fall as far as an end: such answers hold no interval, though the mode is regular.
            rests &= np.isfinite(curved.threshold).all(axis=1)
            lost = (status == Status.OK) & ~rests
            status[lost] = np.where(step.is_best[lost], Status.SEPARATED, Status.FLAT)
            point = curved.where(~rests, point)
        if self.method in ON_LIKELIHOOD:
            # Any place between the two levels is as likely: the climb's end among them would be chance.
            stepped = (status == Status.SEPARATED) & _within(step.place, point.threshold)
            point.theta[stepped, THRESHOLD] = step.place[stepped]
        after_a_track = np.zeros(len(self.counts), dtype=bool)
        if self.method in TOO_NARROW:
            after_a_track = stand_as_after_a_track(self.counts)
        findings = _Findings(self, status, shares, point, mode, binomial, self._deviance(basis), after_a_track)
        return tuple(findings.result(i) for i in range(len(self.counts)))

    def _marginals(self, mode: Mode, eta: Array | None = None) -> Marginals:
        """The posterior of every data set with two levels or more, binomial or with overdispersion about `eta`."""
        all_sets, chosen = Marginals.empty(len(self.counts)), np.flatnonzero(self.counts.n_levels > 1)
        prior = replace(self.prior[chosen], overdispersion=None if eta is None else eta[chosen])
        of_chosen = batched_marginals(self.curve, self.counts[chosen], prior, mode[chosen], self.interval)
        all_sets.put(chosen, of_chosen, np.ones(len(chosen), dtype=bool))
        return all_sets

    def _of_posterior(self, mode: Mode, posterior: Marginals, step: StepFit, eta: Array | None = None) -> PointEstimate:
        """The mode, median or mean. Of a step the mode is a whole stretch, whose middle is taken; where the mode lies
        on an edge of the priors or outside of its own interval, the median stands for it."""
        median, theta = posterior.mean.copy(), _with_width(mode.theta)
        median[:, [THRESHOLD, LOG_WIDTH]] = posterior.median
        if self.estimate == "mean":
            mean_eta = None if eta is None else posterior.overdispersion
            return PointEstimate(posterior.mean, posterior.threshold, posterior.width, mean_eta)
        theta[:, THRESHOLD] = np.where(step.is_between, step.place, theta[:, THRESHOLD])
        is_held = (mode.interior | step.is_between) & _within(theta[:, THRESHOLD], posterior.threshold)
        is_wide = _within(theta[:, LOG_WIDTH], posterior.width)
        is_held &= (is_wide | step.is_between) & (self.estimate == "mode")
        theta[:, LOG_WIDTH] = np.where(is_wide, theta[:, LOG_WIDTH], median[:, LOG_WIDTH])
        return PointEstimate(np.where(is_held[:, None], theta, median), posterior.threshold, posterior.width, eta)

    def _of_curvature(
        self, basis: Mode, eta: Array | None, rests: Bools, n_resamples: int, rng: np.random.Generator | None
    ) -> PointEstimate:
        """The mode with Wald's intervals; where a set `rests` on it, the threshold's by profile or bootstrap if these
        are asked for."""
        z = float(ndtri((1 + self.interval) / 2)) * np.array([-1.0, 1.0])
        threshold = basis.theta[:, [THRESHOLD]] + z * basis.threshold_sd[:, None]
        with np.errstate(over="ignore"):
            width = np.exp(basis.theta[:, [LOG_WIDTH]] + z * basis.log_width_sd[:, None])
        chosen = np.flatnonzero(rests)
        if self.method in ("profile", "bootstrap") and len(chosen):
            threshold[chosen] = self._refined(chosen, basis[chosen], n_resamples, rng)
        return PointEstimate(_with_width(basis.theta), threshold, width, eta)

    def _refined(self, chosen: Indices, basis: Mode, n_resamples: int, rng: np.random.Generator | None) -> Array:
        """The intervals that cost more than a Hessian."""
        sets, prior = self.counts[chosen], self.prior[chosen]
        if rng is not None and self.method == "bootstrap":
            return bootstrap(self.curve, sets, prior, basis, self.interval, n_resamples, rng)
        return profile(self.curve, sets, replace(prior, on_curve=False), basis, self.interval)

    def _deviance(self, basis: Mode) -> Array:
        best = saturated_log_likelihood(self.counts)
        # A perfect fit may round to below 0.
        return np.maximum(2 * (best - log_likelihood(self.curve, self.counts, basis.theta)), 0.0)


def is_regular(mode: Mode) -> Bools:
    """Whether the curvature at a mode is one to rest on."""
    return np.asarray(mode.interior & (mode.threshold_sd < WIDEST_SD) & (mode.log_width_sd < WIDEST_LOG_SD))


def _with_width(theta: Array) -> Array:
    """With the width in place of its logarithm."""
    with np.errstate(over="ignore"):
        return np.concatenate([theta[:, :LOG_WIDTH], np.exp(theta[:, [LOG_WIDTH]]), theta[:, LOG_WIDTH + 1 :]], axis=1)


def _within(x: Array, ends: Array) -> Bools:
    return np.asarray((ends[:, 0] <= x) & (x <= ends[:, 1]))


@dataclass(frozen=True)
class _Findings:
    """Everything known of each data set, to be said of one after the other in the unit of its levels."""

    of: Fitting
    status: Statuses
    shares: Array
    point: PointEstimate
    mode: Mode
    found: Marginals
    deviance: Array
    after_a_track: Bools

    def result(self, i: int) -> ThresholdFit:
        of, status, point = self.of, Status(self.status[i]), self.point
        has_threshold, spread = self._has_threshold(i, status), float(of.counts.spread[i])
        low, high = (self._level(i, end) for end in point.threshold[i])
        m, width, lapse, guess = (float(value) for value in point.theta[i])
        has_ends = has_threshold or status in CENSORED
        has_width = has_threshold and status != Status.SEPARATED  # of a step the width has an upper bound only
        centres = (self.mode.theta[i, THRESHOLD], self.found.median[i, 0], self.found.mean[i, THRESHOLD])
        mode, median, mean = (self._level(i, float(u)) if has_threshold else None for u in centres)
        below, within, above = self._shares(i)
        return ThresholdFit(
            threshold=self._level(i, m) if has_threshold else None,
            width=width * spread if has_width else None,
            lapse_rate=lapse if has_threshold else None,
            guess_rate=guess if has_threshold else None,
            overdispersion=float(point.eta[i]) if has_threshold and point.eta is not None else None,
            interval_low=low if has_ends and status != Status.BELOW else None,
            interval_high=high if has_ends and status != Status.ABOVE else None,
            width_low=_finite(float(point.width[i, 0]) * spread) if has_width else None,
            width_high=_finite(float(point.width[i, 1]) * spread) if has_threshold else None,
            status=status,
            deviance=float(self.deviance[i]) if has_threshold else None,
            n_trials=int(of.counts.n_trials[i].sum()),
            n_levels=int(of.counts.n_levels[i]),
            shape=of.shape,
            method=of.method,
            interval=of.interval,
            note=self._note(i, status),
            threshold_mode=mode,
            threshold_median=median,
            threshold_mean=mean,
            probability_below=below,
            probability_within=within,
            probability_above=above,
        )

    def _has_threshold(self, i: int, status: Status) -> bool:
        if status in WITH_THRESHOLD:
            return True
        inside = abs(float(self.point.theta[i, THRESHOLD])) <= 0.5
        return inside and status in FITTED_ANYWAY and bool(self.of.counts.n_levels[i] > 1)

    def _shares(self, i: int) -> tuple[float | None, ...]:
        if self.of.counts.n_levels[i] < 2:
            return None, None, None
        within, below, above = (float(share) for share in self.shares[i, :3])
        return below, within, above

    def _level(self, i: int, u: float) -> float | None:
        level = float(self.of.counts.centre[i] + self.of.counts.spread[i] * u)
        if self.of.curve.on_log_levels:
            with np.errstate(over="ignore"):
                level = float(np.exp(level))
        return _finite(level)

    def _note(self, i: int, status: Status) -> str:
        counts = self.of.counts
        if status == Status.TOO_FEW_LEVELS and counts.n_levels[i] == 1:
            k, n = counts.n_yes[i].sum(), counts.n_trials[i].sum()
            low, high = proportion_interval(k, n, self.of.interval)
            return f"one level only: {k:.0f} of {n:.0f} answers, a rate from {low:.3f} to {high:.3f}; no threshold"
        if status == Status.OK and self.after_a_track[i]:
            return AFTER_A_TRACK
        return status.note


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


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
    ends, tails = [], ndtri((1 + interval * np.array([-1.0, 1.0])) / 2)
    for i, theta in enumerate(mode.theta):
        same = np.full(n_resamples, i)
        chance = np.exp(log_chances(shape, counts.u[i], theta)[0])
        drawn = rng.binomial(counts.n_trials[i].astype(np.int64), np.minimum(chance, 1.0), (n_resamples, len(chance)))
        # Catch trials are answers too: what is known of a free guess rate varies with them.
        alarms = rng.binomial(int(prior.n_catch[i]), theta[GUESS], n_resamples).astype(np.float64)
        resampled = replace(counts[same], n_yes=drawn.astype(np.float64))
        start = np.broadcast_to(theta, (n_resamples, len(theta)))
        refits = climb(shape, resampled, replace(prior[same], n_false_alarms=alarms), start).theta[:, THRESHOLD]
        away = refits - theta[THRESHOLD]
        n_below = np.sum(away < -SAME) + 0.5 * np.sum(np.abs(away) <= SAME)
        # Half a draw more on each side keeps the bias finite where all draws lie on one side.
        bias = ndtri((n_below + 0.5) / (n_resamples + 1))
        ends.append(np.quantile(refits, ndtr(2 * bias + tails)))
    return np.stack(ends)
