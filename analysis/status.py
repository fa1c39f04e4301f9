"""What the data can tell about a threshold, decided from the counts and the mode, the same for every
method."""

from enum import StrEnum

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import isotonic_regression
from scipy.special import betaincinv
from scipy.stats import chi2

from tactometry.analysis.counts import Array, Counts
from tactometry.analysis.likelihood import (
    THRESHOLD,
    constant_log_likelihood,
    log_likelihood,
    saturated_log_likelihood,
)
from tactometry.analysis.mode import Mode
from tactometry.analysis.prior import BETA_B, Prior
from tactometry.analysis.responses import weighted
from tactometry.analysis.step import Step
from tactometry.psychometric import Shape

RISE_CRITERION = 1.0
"""Likelihood ratio (2 x difference of logarithms) of a rise against a constant rate: a standard error of
slope."""
RISE_FROM_AN_ASYMPTOTE = 6.635
"""The same where the answers together are no more than guesses, or at the ceiling: chi-square with 1 df at 1 %."""
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
    Status.FLAT: "the answers do not rise with the level: no threshold can be told",
    Status.NON_MONOTONE: "the answers fall somewhere with rising level, more than chance explains",
    Status.TOO_FEW_LEVELS: "fewer than three levels: threshold and width rest on the prior",
    Status.NO_DATA: "no trial was given",
}


def statuses(shape: Shape, counts: Counts, prior: Prior, mode: Mode, step: Step) -> list[Status]:
    """The status of each data set, the first that applies of: no data, one level, falling, not rising, one
    step, threshold outside the levels, two levels."""
    k, n = counts.n_yes.sum(axis=1), counts.n_trials.sum(axis=1)
    falls = _falls(counts)
    constant = [_constant_status(k[i], n[i], _guess(prior, mode, i)) for i in range(len(counts))]
    is_between = np.array([status == Status.FLAT for status in constant], dtype=bool)
    rise = 2 * (log_likelihood(shape, counts, mode.theta) - constant_log_likelihood(k, n))
    rises = rise >= np.where(is_between, RISE_CRITERION, RISE_FROM_AN_ASYMPTOTE)
    low, high = _range(counts)
    found = []
    for i in range(len(counts)):
        m = mode.theta[i, THRESHOLD]
        tests = (
            (n[i] == 0, Status.NO_DATA),
            (counts.n_levels[i] == 1, Status.TOO_FEW_LEVELS),
            (falls[i], Status.NON_MONOTONE),
            (k[i] == n[i], Status.BELOW),
            (not rises[i], constant[i]),
            (m < low[i], Status.BELOW),
            (m > high[i], Status.ABOVE),
            (step.is_between[i], Status.SEPARATED),
            (counts.n_levels[i] == 2, Status.TOO_FEW_LEVELS),
        )
        found.append(next((status for applies, status in tests if applies), Status.OK))
    return found


def _range(counts: Counts) -> tuple[Array, Array]:
    used = counts.n_trials > 0
    return np.where(used, counts.u, np.inf).min(axis=1), np.where(used, counts.u, -np.inf).max(axis=1)


def _guess(prior: Prior, mode: Mode, i: int) -> float:
    """The guess rate, or for a free one what the catch trials say (the prior's mean without them)."""
    if prior.guess_rate is not None:
        return prior.guess_rate
    return float((1 + prior.n_false_alarms[i]) / (1 + BETA_B + prior.n_catch[i]))


def _constant_status(k: float, n: float, guess: float) -> Status:
    """What a constant rate means: no more than chance, a ceiling, or neither."""
    low, high = proportion_interval(k, n, 0.95)
    if low <= guess:
        return Status.ABOVE
    return Status.BELOW if high >= CEILING_RATE else Status.FLAT


def proportion_interval(k: float, n: float, interval: float) -> tuple[float, float]:
    """Clopper and Pearson's exact interval of a proportion.

    >>> [round(end, 4) for end in proportion_interval(15, 20, 0.95)]
    [0.509, 0.9134]
    """
    tail = (1 - interval) / 2
    low = 0.0 if k == 0 else float(betaincinv(k, n - k + 1, tail))
    high = 1.0 if k == n else float(betaincinv(k + 1, n - k, 1 - tail))
    return low, high


def _falls(counts: Counts) -> NDArray[np.bool_]:
    """A falling trend (score test), or drops that no rising function explains (isotonic against
    saturated)."""
    with np.errstate(divide="ignore", invalid="ignore"):
        rate = counts.n_yes.sum(axis=1) / counts.n_trials.sum(axis=1)
        mean = (counts.u * counts.n_trials).sum(axis=1) / counts.n_trials.sum(axis=1)
        away = counts.u - mean[:, None]
        score = (away * (counts.n_yes - rate[:, None] * counts.n_trials)).sum(axis=1)
        z = score / np.sqrt(rate * (1 - rate) * (away**2 * counts.n_trials).sum(axis=1))
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
                fitted[i] = (weighted(k, np.log(p)) + weighted(n - k, np.log1p(-np.minimum(p, 1)))).sum()
    return fitted
