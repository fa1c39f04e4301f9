"""Statuses of thresholds, from the counts and the posterior.

Four explanations are weighed by Bayes factors (Kass and Raftery 1995, Journal of the American Statistical Association
90, 773-795): the levels meet the rise of the function (some level lies between its 0.05 and 0.95 points, or levels lie
on both sides of it); all levels lie on the upper asymptote; all on the lower one; or the chance is another constant.
The threshold may lie farther away than any curve of the fit, where only an asymptote is left: the evidence of such
constant chances has a closed form. The ratios depend on the likelihood alone, not on how the levels were chosen, so
adaptive tracks are not penalised. Answers that no curve produced reach a Bayes factor of b for a curve in at most
one of b cases, whatever the procedure (Markov's inequality).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import betainc, betaln, logsumexp, xlog1py, xlogy

from ..arrays import Array, Bools, StatusWithNote
from ..distributions import ChiSquare, exact_interval
from .counts import Counts
from .likelihood import GUESS, LAPSE, constant_log_likelihood, saturated_log_likelihood
from .log_posterior import LARGEST_RATE, LogPosterior, Prior, log_rate_mass
from .mode import Mode
from .posterior import Marginals

HELD = 0.8
"""The posterior probability from which an explanation of the answers is taken: four to one."""
TREND_CRITERION = -2.576
"""z of a falling trend, one-sided at 0.5 %."""
DROP_SIGNIFICANCE = 0.01
CEILING_RATE = 0.9
"""A constant rate that may be this high is a ceiling."""
TOLERATED = 1.0
"""A difference of log-likelihoods that the data do not resolve."""


@dataclass(frozen=True)
class StepFit:
    """Best step function, with its place on the scale of `Counts.u`.

    `is_best`: no curve fits better. `is_between`: the step also lies between two levels, or moving it there costs
    a likelihood ratio below e^1, so that no level shows an intermediate rate.
    """

    is_best: Bools
    is_between: Bools
    place: Array


class Status(StatusWithNote):
    """Status of a threshold: ``ok``, or why it is missing or only a bound."""

    OK = "ok", ""
    BELOW = "threshold_below_range", "the threshold is below the levels tested: the interval's upper end is its bound"
    ABOVE = "threshold_above_range", "the threshold is above the levels tested: the interval's lower end is its bound"
    SEPARATED = "separated", "the answers change in one step between levels: the width has an upper bound only"
    FLAT = (
        "flat",
        "a constant rate explains the answers about as well as a rise: no threshold is given, only the interval",
    )
    NON_MONOTONE = "non_monotone", "the answers fall somewhere with rising level, more than chance explains"
    TOO_FEW_LEVELS = "too_few_levels", "fewer than three levels: threshold and width rest on the prior"
    NO_DATA = "no_data", "no trial was given"


CEILING_WEIGHT, GUESSES_WEIGHT, CONSTANT_WEIGHT = 0.3, 3.5, 0.05
"""Prior weights, relative to 1 for the curves of the fit, of a threshold so far below, or above, the levels that only
an asymptote is seen, and of no rise at all. Unverified defaults: with them the bias study (docs/reference/analysis.md)
keeps the shares of wrong statuses. Guesses weigh more, because by luck they rise with the level more often than answers
at a ceiling do."""

Statuses = NDArray[np.object_]


def notes(counts: Counts, status: Statuses, interval: float) -> list[str]:
    """Return the explanation of each status."""
    said = [Status(word).note for word in status]
    for i in np.flatnonzero((status == Status.TOO_FEW_LEVELS) & (counts.n_levels == 1)):
        k, n = counts.n_yes[i].sum(), counts.n_trials[i].sum()
        low, high = exact_interval(k, n, interval)
        said[i] = f"one level only: {k:.0f} of {n:.0f} answers, a rate from {low:.3f} to {high:.3f}; no threshold"
    return said


def statuses(posterior: LogPosterior, shares: Array, step: StepFit) -> list[Status]:
    """Return the first status that applies to each data set."""
    counts = posterior.counts
    k, n = counts.n_yes.sum(axis=1), counts.n_trials.sum(axis=1)
    low, high = exact_interval(k, n)
    is_outside = shares[:, 0] < HELD
    tests = (
        (n == 0, Status.NO_DATA),
        (counts.n_levels == 1, Status.TOO_FEW_LEVELS),
        (_falls(counts), Status.NON_MONOTONE),
        (k == n, Status.BELOW),
        (is_outside & (shares[:, 1] >= HELD) & (high >= CEILING_RATE), Status.BELOW),
        (is_outside & (shares[:, 2] >= HELD) & (low <= _highest_guess(posterior.prior)), Status.ABOVE),
        (is_outside, Status.FLAT),
        (step.is_between, Status.SEPARATED),
        (counts.n_levels == 2, Status.TOO_FEW_LEVELS),
    )
    applies, verdicts = zip(*tests, strict=True)
    return [Status(word) for word in np.select(applies, verdicts, Status.OK)]


def _highest_guess(prior: Prior) -> Array | float:
    """Return the guess rate, or the highest plausible one if it is free."""
    if prior.guess_rate is not None:
        return prior.guess_rate
    _, high = exact_interval(prior.n_false_alarms, prior.n_catch)
    return np.where(prior.n_catch > 0, high, 1 / (1 + prior.guess_beta))


def _falls(counts: Counts) -> Bools:
    """Return True for a falling trend or drops that no rising curve explains."""
    n = counts.n_trials.sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        # Equal answers or one level make z 0 / 0; NaN is below no criterion.
        rate = counts.n_yes.sum(axis=1) / n
        mean = (counts.u * counts.n_trials).sum(axis=1) / n
        away = counts.u - mean[:, None]
        excess = counts.n_yes - rate[:, None] * counts.n_trials
        variance = rate * (1 - rate) * (away**2 * counts.n_trials).sum(axis=1)
        z = (away * excess).sum(axis=1) / np.sqrt(variance)
    drop = 2 * (saturated_log_likelihood(counts) - _isotonic_log_likelihood(counts))
    critical = ChiSquare.ppf(1 - DROP_SIGNIFICANCE, np.maximum(counts.n_levels - 1, 1))
    return np.asarray((z < TREND_CRITERION) | (drop > critical))


def _isotonic_log_likelihood(counts: Counts) -> Array:
    fitted = saturated_log_likelihood(counts)  # exact if the answers rise already
    for i in range(len(counts)):
        used = counts.n_trials[i] > 0
        k, n = counts.n_yes[i, used], counts.n_trials[i, used]
        if np.any(np.diff(k / n) < 0):
            p = np.minimum(rising_fit(k / n, n), 1)  # a mean of ones may round to above 1
            fitted[i] = (xlogy(k, p) + xlog1py(n - k, -p)).sum()
    return fitted


def rising_fit(values: Array, weights: Array) -> Array:
    """Return the rising sequence nearest to the values by weighted squares.

    The method is pool adjacent violators. `scipy.optimize.isotonic_regression` is slow to load.
    """
    blocks: list[tuple[float, float, int]] = []
    for value, weight in zip(values.tolist(), weights.tolist(), strict=True):
        mean, total, size = value, weight, 1
        while blocks and blocks[-1][0] >= mean:
            before, its_total, its_size = blocks.pop()
            mean = (before * its_total + mean * total) / (its_total + total)
            total, size = total + its_total, size + its_size
        blocks.append((mean, total, size))
    means, _, sizes = zip(*blocks, strict=True)
    return np.repeat(means, sizes)


def best_step(posterior: LogPosterior, likeliest: Mode) -> StepFit:
    """Return the best step with the asymptotes of the likeliest curve.

    At most one level has another rate. If it fits at least as well as the likeliest curve, the steepness has no upper
    bound. A step between two levels lies at their middle. A step before or after all levels does not count.
    """
    counts = posterior.counts
    at_level, between = _step_likelihoods(counts, likeliest)
    cut = np.arange(between.shape[1])  # cut i lies between the levels i - 1 and i
    has_both_sides = (cut > 0) & (cut < counts.n_levels[:, None])
    between = np.where(has_both_sides, between, -np.inf)
    best = np.maximum(at_level.max(axis=1), between.max(axis=1))
    is_best = best >= posterior.log_likelihood(likeliest.theta) - 1e-6
    is_between = between.max(axis=1) >= best - TOLERATED
    rows, gap = np.arange(len(counts)), between.argmax(axis=1)
    last = counts.u.shape[1] - 1
    below, above = counts.u[rows, np.maximum(gap - 1, 0)], counts.u[rows, np.minimum(gap, last)]
    middle = (below + above) / 2
    place = np.where(is_between, middle, counts.u[rows, at_level.argmax(axis=1)])
    return StepFit(is_best, is_best & is_between, place)


def _step_likelihoods(counts: Counts, likeliest: Mode) -> tuple[Array, Array]:
    k, n = counts.n_yes, counts.n_trials
    lapse, guess = likeliest.theta[:, LAPSE, None], likeliest.theta[:, GUESS, None]
    # Sums need finite numbers.
    below = np.maximum(xlogy(k, guess) + xlog1py(n - k, -guess), -1e12)
    above = np.maximum(xlog1py(k, -lapse) + xlogy(n - k, lapse), -1e12)
    none = np.zeros((len(counts), 1))
    left = np.hstack([none, np.cumsum(below, axis=1)])  # entry i: levels before i, on the lower asymptote
    right = np.hstack([np.cumsum(above[:, ::-1], axis=1)[:, ::-1], none])  # levels from i on, on the upper one
    at_level = left[:, :-1] + constant_log_likelihood(k, n) + right[:, 1:]
    return at_level, left + right


def verdict_shares(posterior: LogPosterior, marginals: Marginals) -> Array:
    """Return probabilities (n_sets, 4) of the four explanations.

    The levels meet the rise, lie above it, lie below it, or there is no rise.
    """
    met = 1 - marginals.beyond.sum(axis=1, keepdims=True)
    curves = marginals.log_evidence[:, None] + _logarithm(np.hstack([met, marginals.beyond]))
    ceiling, guesses, constant = constant_evidence(posterior.counts, posterior.prior)
    with np.errstate(invalid="ignore"):
        # A rise below all levels puts them on the upper asymptote, one above all levels on the guess rate.
        below = np.logaddexp(curves[:, 1], np.log(CEILING_WEIGHT) + ceiling)
        above = np.logaddexp(curves[:, 2], np.log(GUESSES_WEIGHT) + guesses)
        no_rise = np.log(CONSTANT_WEIGHT) + constant
        explanations = np.stack([curves[:, 0], below, above, no_rise], axis=1)
        total = logsumexp(explanations, axis=1, keepdims=True)
        return np.asarray(np.exp(explanations - total))


def constant_evidence(counts: Counts, prior: Prior) -> tuple[Array, Array, Array]:
    """Return the log evidence (n_sets,) of both asymptotes and any constant.

    The last is uniform between the asymptotes if they are known. All include the answers to catch trials.
    """
    k, n = counts.n_yes.sum(axis=1), counts.n_trials.sum(axis=1)
    alarms, correct = prior.n_false_alarms, prior.n_catch - prior.n_false_alarms
    low, high = prior.guess_rate or 0.0, 1 - (prior.lapse_rate or 0.0)
    share = np.asarray(betainc(k + 1, n - k + 1, high) - betainc(k + 1, n - k + 1, low))
    any_chance = betaln(k + 1, n - k + 1) + _logarithm(share)
    catch = np.zeros(len(counts))
    if prior.guess_rate is None:
        # Answers to catch trials are guesses: they share the rate of a lower asymptote, else they have a separate one.
        catch = _log_mean_chance(None, prior.guess_beta, alarms, correct)
        guesses = _log_mean_chance(None, prior.guess_beta, k + alarms, n - k + correct)
    else:
        guesses = _log_mean_chance(prior.guess_rate, prior.guess_beta, k, n - k)
    ceiling = _log_mean_chance(prior.lapse_rate, prior.lapse_beta, n - k, k)
    return ceiling + catch, guesses, any_chance - np.log(high - low) + catch


def _log_mean_chance(rate: float | None, beta: float, k: Array, rest: Array) -> Array:
    if rate is None:
        a, b = k + 1, rest + beta
        share = np.asarray(betainc(a, b, LARGEST_RATE), dtype=np.float64)  # a free rate ends there, before 1
        return betaln(a, b) + _logarithm(share) - log_rate_mass(beta)
    return np.asarray(xlogy(k, rate) + xlog1py(rest, -rate))


def _logarithm(x: Array) -> Array:
    """Return the logarithm, minus infinity for values rounded to 0 or below."""
    with np.errstate(divide="ignore"):
        return np.asarray(np.log(np.maximum(x, 0.0)), dtype=np.float64)
