"""What the data can tell about a threshold, decided from the counts and the posterior, the same for every
method."""

from enum import StrEnum

import numpy as np
from scipy.optimize import isotonic_regression
from scipy.special import betaincinv
from scipy.stats import chi2

from ..arrays import Array, Bools
from .chances import weighted
from .counts import Counts
from .likelihood import saturated_log_likelihood
from .prior import Prior
from .step import StepFit

HELD = 0.8
"""The posterior probability from which an explanation of the answers is taken: four to one."""
TREND_CRITERION = -2.576
"""z of a falling trend, one-sided at 0.5 %."""
DROP_SIGNIFICANCE = 0.01
CEILING_RATE = 0.9
"""A constant rate that may be this high is a ceiling."""


class Status(StrEnum):
    OK = "ok"
    BELOW = "threshold_below_range"
    ABOVE = "threshold_above_range"
    SEPARATED = "separated"
    FLAT = "flat"
    NON_MONOTONE = "non_monotone"
    TOO_FEW_LEVELS = "too_few_levels"
    NO_DATA = "no_data"


NOTES = {
    Status.OK: "",
    Status.BELOW: "the threshold is below the levels tested: the interval's upper end is its bound",
    Status.ABOVE: "the threshold is above the levels tested: the interval's lower end is its bound",
    Status.SEPARATED: "the answers change in one step between levels: the width has an upper bound only",
    Status.FLAT: "a constant rate explains the answers about as well as a rise: no threshold can be told",
    Status.NON_MONOTONE: "the answers fall somewhere with rising level, more than chance explains",
    Status.TOO_FEW_LEVELS: "fewer than three levels: threshold and width rest on the prior",
    Status.NO_DATA: "no trial was given",
}

TOO_NARROW = ("ml", "map", "profile")
"""Methods whose intervals are known to be too narrow after an adaptive track."""
AFTER_A_TRACK = (
    "trials stand on the levels as an adaptive track leaves them, where intervals of ml, map and profile hold the "
    "truth too seldom (84 % of map's and 91 % of profile's after 60 trials of QUEST+); take method='posterior'"
)
UNEVEN, FEW = 1e-3, 10


def stand_as_after_a_track(counts: Counts) -> Bools:
    """Whether some levels have more trials than an even spread explains (chi square), or hardly any has two: constant
    stimuli are even."""
    n, n_levels = counts.n_trials.sum(axis=1), np.maximum(counts.n_levels, 1)
    even = np.maximum(n / n_levels, 1.0)[:, None]
    square = np.where(counts.n_trials > 0, (counts.n_trials - even) ** 2 / even, 0.0).sum(axis=1)
    uneven = chi2.sf(square, np.maximum(n_levels - 1, 1)) < UNEVEN
    return np.asarray(uneven | ((n_levels > FEW) & (n < 2 * n_levels)))


def statuses(counts: Counts, prior: Prior, shares: Array, step: StepFit) -> list[Status]:
    """The status of each data set, the first that applies of: no data, one level, falling, all yes, the threshold
    outside of the levels' reach or not to be told, one step, two levels; `shares` are those of `verdict_shares`."""
    k, n = counts.n_yes.sum(axis=1), counts.n_trials.sum(axis=1)
    falls, status = _falls(counts), []
    for i in range(len(counts)):
        tests = (
            (n[i] == 0, Status.NO_DATA),
            (counts.n_levels[i] == 1, Status.TOO_FEW_LEVELS),
            (falls[i], Status.NON_MONOTONE),
            (k[i] == n[i], Status.BELOW),
            (shares[i, 0] < HELD, _outside(shares[i], k[i], n[i], _guess(prior, i))),
            (step.is_between[i], Status.SEPARATED),
            (counts.n_levels[i] == 2, Status.TOO_FEW_LEVELS),
        )
        status.append(next((verdict for applies, verdict in tests if applies), Status.OK))
    return status


def _outside(shares: Array, k: float, n: float, guess: float) -> Status:
    """Of answers that do not hold a threshold; a constant rate that is neither a ceiling's nor guesses' tells none."""
    low, high = proportion_interval(k, n, 0.95)
    if shares[1] >= HELD and high >= CEILING_RATE:
        return Status.BELOW
    return Status.ABOVE if shares[2] >= HELD and low <= guess else Status.FLAT


def _guess(prior: Prior, i: int) -> float:
    """The guess rate, or for a free one the highest that the catch trials allow (the prior's mean without them)."""
    if prior.guess_rate is not None:
        return prior.guess_rate
    if prior.n_catch[i] == 0:
        return 1 / (1 + prior.rate_beta)
    return proportion_interval(prior.n_false_alarms[i], prior.n_catch[i], 0.95)[1]


def proportion_interval(k: float, n: float, interval: float) -> tuple[float, float]:
    """Clopper and Pearson's exact interval of a proportion.

    >>> [round(end, 4) for end in proportion_interval(15, 20, 0.95)]
    [0.509, 0.9134]
    """
    tail = (1 - interval) / 2
    low = 0.0 if k == 0 else float(betaincinv(k, n - k + 1, tail))
    high = 1.0 if k == n else float(betaincinv(k + 1, n - k, 1 - tail))
    return low, high


def _falls(counts: Counts) -> Bools:
    """A falling trend (score test), or drops that no rising function explains (isotonic against
    saturated)."""
    n = counts.n_trials.sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        # Equal answers or one level make z 0 / 0, and NaN is below no criterion.
        rate = counts.n_yes.sum(axis=1) / n
        mean = (counts.u * counts.n_trials).sum(axis=1) / n
        away = counts.u - mean[:, None]
        excess = counts.n_yes - rate[:, None] * counts.n_trials
        variance = rate * (1 - rate) * (away**2 * counts.n_trials).sum(axis=1)
        z = (away * excess).sum(axis=1) / np.sqrt(variance)
    drop = 2 * (saturated_log_likelihood(counts) - _isotonic_log_likelihood(counts))
    critical = chi2.ppf(1 - DROP_SIGNIFICANCE, np.maximum(counts.n_levels - 1, 1))
    return np.asarray((z < TREND_CRITERION) | (drop > critical))


def _isotonic_log_likelihood(counts: Counts) -> Array:
    """Of the best rising function of the level; only sets with a drop between neighbours are fitted."""
    fitted = saturated_log_likelihood(counts)
    for i in range(len(counts)):
        used = counts.n_trials[i] > 0
        k, n = counts.n_yes[i, used], counts.n_trials[i, used]
        if np.any(np.diff(k / n) < 0):
            p = isotonic_regression(k / n, weights=n).x
            with np.errstate(divide="ignore"):
                # A weighted mean of ones may round to above 1, where log1p has no value.
                fitted[i] = (weighted(k, np.log(p)) + weighted(n - k, np.log1p(-np.minimum(p, 1)))).sum()
    return fitted
