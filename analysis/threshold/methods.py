"""The fits of many data sets by one method: statuses from the data, numbers from the method, and where it has none (no
curvature at its mode, a step, a bound) from the posterior.

Intervals of a threshold by profile likelihood and by parametric bootstrap.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from ..arrays import Array, Bools, Indices, Rows
from ..distributions import ChiSquare
from .likelihood import GUESS, LOG_WIDTH, THRESHOLD, log_chances
from .log_posterior import LogPosterior
from .mode import Mode, climb, find_mode, find_overdispersed_mode
from .posterior import Marginals
from .result import ThresholdFit
from .shared_grid import batched_marginals
from .status import HELD, Status, Statuses, StepFit, best_step, notes, statuses, verdict_shares

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
class Estimates(Rows):
    """Parameters (n_sets, 4) with the width in place of its logarithm; ends (n_sets, 2) of threshold and width.

    `method` (n_sets,) names the method that the threshold's interval comes from.
    """

    theta: Array
    threshold: Array
    width: Array
    method: NDArray[np.object_]

    @classmethod
    def by(cls, method: str, theta: Array, threshold: Array, width: Array) -> "Estimates":
        return cls(theta, threshold, width, np.full(len(theta), method, dtype=object))


@dataclass(frozen=True)
class Fitting:
    """Data sets with what is known before them, and how they are fitted."""

    posterior: LogPosterior
    shape: str
    method: str
    interval: float
    estimate: str
    overdispersed: bool
    n_resamples: int
    rng: np.random.Generator | None

    def results(self) -> tuple[ThresholdFit, ...]:
        posterior = self.posterior
        mode = find_mode(posterior)
        likeliest = find_mode(posterior.under(on_curve=False), mode.theta)
        step = best_step(posterior, likeliest)
        marginals = self._marginals(mode)
        shares = verdict_shares(posterior, marginals)  # the status is that of the binomial
        status = np.array(statuses(posterior, shares, step), dtype=object)
        eta = None
        if self.overdispersed:
            mode, eta = find_overdispersed_mode(posterior.under(on_curve=True))
            marginals = self._marginals(mode, eta)
        estimates, basis = self._of_posterior(mode, marginals, step), mode
        if self.method == "posterior":
            eta = marginals.overdispersion if self.overdispersed and self.estimate == "mean" else eta
        else:
            if self.method in ON_LIKELIHOOD:
                basis, eta = self._likeliest(likeliest)
            estimates, status = self._of_curvature(basis, status, step, estimates)
        on_levels = {
            "threshold_mode": mode.theta[:, THRESHOLD],
            "threshold_median": marginals.threshold[:, 1],
            "threshold_mean": marginals.mean[:, THRESHOLD],
        }
        deviance = np.maximum(posterior.deviance(basis.theta), 0.0)  # a perfect fit may round to below 0
        return self._fits(status, estimates, shares, on_levels, {"deviance": deviance, "overdispersion": eta})

    def _likeliest(self, binomial: Mode) -> tuple[Mode, Array | None]:
        """The mode of the likelihood, and its overdispersion."""
        if self.overdispersed:
            return find_overdispersed_mode(self.posterior.under(on_curve=False))
        return binomial, None

    def _marginals(self, mode: Mode, eta: Array | None = None) -> Marginals:
        """The posterior of every data set with two levels or more, binomial or with overdispersion about `eta`."""
        chosen = np.flatnonzero(self.posterior.counts.n_levels > 1)
        posterior = self.posterior[chosen].under(overdispersion=None if eta is None else eta[chosen])
        of_chosen = batched_marginals(posterior, mode[chosen], self.interval)
        return Marginals.empty(len(self.posterior)).replaced(chosen, of_chosen)

    def _of_posterior(self, mode: Mode, marginals: Marginals, step: StepFit) -> Estimates:
        """The mode, median or mean. Of a step the mode is a whole stretch, whose middle is taken; where the mode lies
        on an edge of the priors or outside of its own interval, the median stands for it."""
        threshold, width = marginals.threshold[:, [0, 2]], marginals.width[:, [0, 2]]
        if self.estimate == "mean":
            return Estimates.by("posterior", marginals.mean, threshold, width)
        median = marginals.mean.copy()
        median[:, THRESHOLD] = marginals.threshold[:, 1]
        median[:, LOG_WIDTH] = marginals.width[:, 1]
        theta = _with_width(mode.theta)
        theta[:, THRESHOLD] = np.where(step.is_between, step.place, theta[:, THRESHOLD])
        holds_width = _within(theta[:, LOG_WIDTH], width)
        theta[:, LOG_WIDTH] = np.where(holds_width, theta[:, LOG_WIDTH], median[:, LOG_WIDTH])
        is_summit = step.is_between | (mode.interior & holds_width)
        is_held = is_summit & _within(theta[:, THRESHOLD], threshold) & (self.estimate == "mode")
        return Estimates.by("posterior", np.where(is_held[:, None], theta, median), threshold, width)

    def _of_curvature(
        self, basis: Mode, status: Statuses, step: StepFit, of_posterior: Estimates
    ) -> tuple[Estimates, Statuses]:
        """Those of the mode, where it is one to rest on, and the statuses of sets whose mode is none."""
        rests = is_regular(basis) & np.isin(status, (Status.OK, *FITTED_ANYWAY))
        curved = self._wald(basis)
        chosen = np.flatnonzero(rests)
        if self.method in ("profile", "bootstrap") and len(chosen):
            curved.threshold[chosen] = self._exact_interval(self.posterior[chosen], basis[chosen])
        # A profile may never fall as far as an end: such answers hold no interval, though the mode is regular.
        rests &= np.isfinite(curved.threshold).all(axis=1)
        lost = (status == Status.OK) & ~rests
        of_step = np.where(step.is_best, Status.SEPARATED, Status.FLAT)
        status = np.where(lost, of_step, status)
        estimates = curved.where(rests, of_posterior)
        if self.method == "profile":
            estimates = self._with_profiled_steps(estimates, basis, np.flatnonzero(status == Status.SEPARATED))
        if self.method in ON_LIKELIHOOD:
            # Any place between the two levels is as likely: the climb's end among them would be chance.
            stepped = (status == Status.SEPARATED) & _within(step.place, estimates.threshold)
            estimates.theta[stepped, THRESHOLD] = step.place[stepped]
        return estimates, status

    def _wald(self, basis: Mode) -> Estimates:
        """The mode with Wald's intervals."""
        z = float(ndtri((1 + self.interval) / 2)) * np.array([-1.0, 1.0])
        threshold = basis.theta[:, [THRESHOLD]] + z * basis.sd[:, [THRESHOLD]]
        with np.errstate(over="ignore"):
            width = np.exp(basis.theta[:, [LOG_WIDTH]] + z * basis.sd[:, [LOG_WIDTH]])
        return Estimates.by(self.method, _with_width(basis.theta), threshold, width)

    def _with_profiled_steps(self, estimates: Estimates, basis: Mode, chosen: Indices) -> Estimates:
        """The profile's interval for answers of one step, whose mode is no place to rest on but whose profile ends."""
        if not len(chosen):
            return estimates
        ends = self._exact_interval(self.posterior[chosen], basis[chosen])
        ended = np.asarray(np.isfinite(ends).all(axis=1))
        profiled = replace(estimates[chosen], threshold=ends, method=np.full(len(chosen), self.method, dtype=object))
        return estimates.replaced(chosen[ended], profiled[ended])

    def _exact_interval(self, posterior: LogPosterior, basis: Mode) -> Array:
        """The intervals that cost more than a Hessian."""
        if self.rng is not None and self.method == "bootstrap":
            return bootstrap(posterior, basis, self.interval, self.n_resamples, self.rng)
        return profile(posterior.under(on_curve=False), basis, self.interval)

    def _fits(
        self,
        status: Statuses,
        estimates: Estimates,
        shares: Array,
        on_levels: Mapping[str, Array],
        further: Mapping[str, Array | None],
    ) -> tuple[ThresholdFit, ...]:
        """All that is known of each data set, in the unit of its levels; None for what its status does not hold."""
        counts, (threshold, width, lapse, guess) = self.posterior.counts, estimates.theta.T
        has_curve = counts.n_levels > 1
        is_fitted_anyway = np.isin(status, FITTED_ANYWAY) & has_curve & (np.abs(threshold) <= 0.5)
        has_threshold = np.isin(status, WITH_THRESHOLD) | is_fitted_anyway
        has_width = has_threshold & (status != Status.SEPARATED)  # of a step the width has an upper bound only
        has_low, has_high = _has_ends(status, shares, has_threshold).T & has_curve
        low, high = (self._levels(end) for end in estimates.threshold.T)
        narrow, wide = (counts.spread * end for end in estimates.width.T)
        columns = {
            "threshold": _column(self._levels(threshold), has_threshold),
            "width": _column(counts.spread * width, has_width),
            "lapse_rate": _column(lapse, has_threshold),
            "guess_rate": _column(guess, has_threshold),
            "interval_low": _column(low, has_low),
            "interval_high": _column(high, has_high),
            "width_low": _column(narrow, has_width),
            "width_high": _column(wide, has_threshold),
            "method": np.where(has_low | has_high, estimates.method, self.method).tolist(),
            "status": [Status(word) for word in status],
            "n_trials": counts.n_trials.sum(axis=1).astype(int).tolist(),
            "n_levels": counts.n_levels.tolist(),
            "note": notes(counts, status, self.method, self.interval),
        }
        columns |= {name: _column(self._levels(u), has_threshold) for name, u in on_levels.items()}
        columns |= {name: _column(values, has_threshold) for name, values in further.items()}
        explanations = zip(("within", "below", "above"), shares.T, strict=False)  # the fourth is that there is no rise
        columns |= {f"probability_{name}": _column(share, has_curve) for name, share in explanations}
        rows = (dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True))
        return tuple(ThresholdFit(**row, shape=self.shape, interval=self.interval) for row in rows)

    def _levels(self, u: Array) -> Array:
        counts = self.posterior.counts
        levels = counts.centre + counts.spread * u
        with np.errstate(over="ignore"):
            return np.exp(levels) if self.posterior.shape.on_log_levels else levels


def _has_ends(status: Statuses, shares: Array, has_threshold: Bools) -> Bools:
    """Return which ends (n_sets, 2) an interval has.

    Without a threshold an end is open unless the answers exclude, as they do for `ok`, that the threshold lies
    beyond the levels on its side.
    """
    is_open = ~has_threshold[:, None] & (shares[:, 1:3] > 1 - HELD)
    is_bound = np.isin(status, CENSORED)
    is_open[is_bound] = status[is_bound, None] == np.array(CENSORED, dtype=object)
    return np.asarray(~is_open)


def _column(values: Array | None, where: Bools) -> list[float | None]:
    """None for what is not known, and for an end that there is none of."""
    if values is None:
        return [None] * len(where)
    known = zip(values.tolist(), where & np.isfinite(values), strict=True)
    return [value if is_known else None for value, is_known in known]


def is_regular(mode: Mode) -> Bools:
    """Whether the curvature at a mode is one to rest on."""
    is_narrow = (mode.sd[:, THRESHOLD] < WIDEST_SD) & (mode.sd[:, LOG_WIDTH] < WIDEST_LOG_SD)
    return np.asarray(mode.interior & is_narrow)


def _with_width(theta: Array) -> Array:
    """With the width in place of its logarithm."""
    theta = theta.copy()
    with np.errstate(over="ignore"):
        theta[:, LOG_WIDTH] = np.exp(theta[:, LOG_WIDTH])
    return theta


def _within(x: Array, ends: Array) -> Bools:
    return np.asarray((ends[:, 0] <= x) & (x <= ends[:, 1]))


def profile(posterior: LogPosterior, mode: Mode, interval: float) -> Array:
    """Where the log-likelihood, maximised over all but the threshold, is chi2(interval)/2 below its maximum.

    Shape (n_sets, 2), on the scale of `Counts.u`; infinite where the profile has no end on that side.
    """
    floor = mode.log_density - ChiSquare.ppf(interval, 1) / 2
    return np.stack([_profile_end(posterior, mode, floor, side) for side in (-1.0, 1.0)], axis=1)


def _profile_end(posterior: LogPosterior, mode: Mode, floor: Array, side: float) -> Array:
    inner, sd = mode.theta[:, THRESHOLD].copy(), mode.sd[:, THRESHOLD]
    reach = np.maximum(2 * sd, 1e-3)  # about where a normal profile ends at 95 %; doubled until it has fallen
    outer, start = inner + side * reach, mode.theta
    for _ in range(MAX_BISECTIONS):
        above, start = _is_above(posterior, outer, start, floor)
        if not (above & (np.abs(outer) < FARTHEST)).any():
            break
        inner = np.where(above, outer, inner)
        outer = np.where(above, outer + side * reach, outer)
        reach = 2 * reach
    endless = above
    # Every climb begins where the last one ended: neighbouring thresholds have neighbouring summits.
    for _ in range(MAX_BISECTIONS):
        middle = (inner + outer) / 2
        above, start = _is_above(posterior, middle, start, floor)
        inner, outer = np.where(above, middle, inner), np.where(above, outer, middle)
        if (np.abs(outer - inner) <= 1e-9 * np.maximum(sd, 1e-9)).all():
            break
    return np.where(endless, side * np.inf, (inner + outer) / 2)


def _is_above(posterior: LogPosterior, threshold: Array, start: Array, floor: Array) -> tuple[Bools, Array]:
    at_threshold = climb(posterior.under(threshold=threshold), start)
    return at_threshold.log_density > floor, at_threshold.theta


def bootstrap(
    posterior: LogPosterior, mode: Mode, interval: float, n_resamples: int, rng: np.random.Generator
) -> Array:
    """Bias-corrected percentiles of the mode's threshold over answers drawn from the fitted function.

    Shape (n_sets, 2), on the scale of `Counts.u` (Efron 1981, bias-corrected percentile method).
    """
    ends, tails = [], ndtri((1 + interval * np.array([-1.0, 1.0])) / 2)
    counts = posterior.counts
    for i, theta in enumerate(mode.theta):
        chance = np.exp(log_chances(posterior.shape, counts.u[i], theta)[0])
        size = (n_resamples, len(chance))
        drawn = rng.binomial(counts.n_trials[i].astype(np.int64), np.minimum(chance, 1.0), size)
        alarms = rng.binomial(int(posterior.prior.n_catch[i]), theta[GUESS], n_resamples)
        redrawn = posterior.redrawn(np.full(n_resamples, i), drawn.astype(np.float64), alarms.astype(np.float64))
        start = np.broadcast_to(theta, (n_resamples, len(theta)))
        refits = climb(redrawn, start).theta[:, THRESHOLD]
        away = refits - theta[THRESHOLD]
        n_below = np.sum(away < -SAME) + 0.5 * np.sum(np.abs(away) <= SAME)
        # Half a draw more on each side keeps the bias finite where all draws lie on one side.
        bias = ndtri((n_below + 0.5) / (n_resamples + 1))
        ends.append(np.quantile(refits, ndtr(2 * bias + tails)))
    return np.stack(ends)
