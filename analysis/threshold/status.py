"""Statuses of thresholds, derived from the counts and the posterior.

Four explanations are compared by Bayes factors (Kass and Raftery 1995, Journal of the American Statistical Association
90, 773-795). First, the levels cover part of the rise of the function: a level lies between its 0.05 and 0.95 points,
or levels lie on both sides of the rise. Second, all levels lie on the upper asymptote. Third, all levels lie on the
lower asymptote. Fourth, the probability is another constant. A threshold may lie farther away than any curve of the
fit, so that only an asymptote is observed; the evidence of constant probabilities has a closed form. The ratios depend
only on the likelihood, not on how the levels were chosen, so adaptive tracks are not penalised. For answers that no
curve produced, a Bayes factor of b in favour of a curve occurs in at most one of b cases, for every procedure (Markov's
inequality).
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
"""Posterior probability at which an explanation of the answers is accepted (odds of four to one)."""
TREND_CRITERION = -2.576
"""z below which a trend counts as falling (one-sided, 0.5 %)."""
DROP_SIGNIFICANCE = 0.01
CEILING_RATE = 0.9
"""A constant rate counts as a ceiling if its interval reaches this rate."""
TOLERATED = 1.0
"""Difference of log-likelihoods that does not distinguish two functions."""


@dataclass(frozen=True)
class StepFit:
    """Best step function, with its position on the scale of `Counts.u`.

    `is_best` means that no curve fits better. `is_between` means that, in addition, the step lies between two levels,
    or moving it there reduces the likelihood by less than a factor of e, so no level shows an intermediate rate.
    """

    is_best: Bools
    is_between: Bools
    place: Array


class Status(StatusWithNote):
    """Status of a threshold: ``ok``, or why it is missing or only a bound."""

    OK = "ok", ""
    BELOW = (
        "threshold_below_range",
        "the threshold is below the tested levels; the upper end of the interval is its bound",
    )
    ABOVE = (
        "threshold_above_range",
        "the threshold is above the tested levels; the lower end of the interval is its bound",
    )
    SEPARATED = (
        "separated",
        "the answers change in a single step between two levels; only an upper bound of the width is known",
    )
    FLAT = (
        "flat",
        "a constant rate explains the answers about as well as a rising function; only an interval is reported",
    )
    NON_MONOTONE = "non_monotone", "the rate falls with rising level by more than chance"
    TOO_FEW_LEVELS = "too_few_levels", "fewer than three levels; threshold and width depend strongly on the prior"
    NO_DATA = "no_data", "there are no trials"


CEILING_WEIGHT, GUESSES_WEIGHT, CONSTANT_WEIGHT = 0.3, 3.5, 0.05
"""Prior weights of three explanations, relative to 1 for the curves of the fit: all levels on the upper asymptote, all
on the lower asymptote, and no rise. These are unverified defaults that limit the rates of wrong statuses in the bias
study (docs/reference/analysis.md). Guesses have a larger weight, as they rise with the level by chance more often than
answers at a ceiling."""

Statuses = NDArray[np.object_]


def notes(counts: Counts, status: Statuses, interval: float) -> list[str]:
    """Return a note that explains each status."""
    texts = [Status(word).note for word in status]
    for i in np.flatnonzero((status == Status.TOO_FEW_LEVELS) & (counts.n_levels == 1)):
        k, n = counts.n_yes[i].sum(), counts.n_trials[i].sum()
        low, high = exact_interval(k, n, interval)
        texts[i] = (
            f"only one level ({k:.0f} of {n:.0f} answers, rate {low:.3f} to {high:.3f}), so there is no threshold"
        )
    return texts


def statuses(posterior: LogPosterior, shares: Array, step: StepFit) -> list[Status]:
    """Return the status of each data set (the first that applies)."""
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
    """Return True for rates that fall more than a rising function allows."""
    n = counts.n_trials.sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        # z is NaN (0 / 0) for equal answers or one level; NaN never passes the criterion.
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
    fitted = saturated_log_likelihood(counts)  # exact if the rates are already increasing
    for i in range(len(counts)):
        used = counts.n_trials[i] > 0
        k, n = counts.n_yes[i, used], counts.n_trials[i, used]
        if np.any(np.diff(k / n) < 0):
            p = np.minimum(rising_fit(k / n, n), 1)  # a mean of ones may round above 1
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

    At most one level has an intermediate rate. If the step fits at least as well as the likeliest curve, the steepness
    has no upper bound. A step between two levels is placed midway between them. Steps outside the range of the levels
    do not count.
    """
    counts = posterior.counts
    at_level, between = _step_likelihoods(counts, likeliest)
    cut = np.arange(between.shape[1])  # cut i lies between levels i - 1 and i
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
    # avoid infinities in sums
    below = np.maximum(xlogy(k, guess) + xlog1py(n - k, -guess), -1e12)
    above = np.maximum(xlog1py(k, -lapse) + xlogy(n - k, lapse), -1e12)
    none = np.zeros((len(counts), 1))
    left = np.hstack([none, np.cumsum(below, axis=1)])  # entry i: levels before i, on the lower asymptote
    right = np.hstack([np.cumsum(above[:, ::-1], axis=1)[:, ::-1], none])  # levels from i on, on the upper asymptote
    at_level = left[:, :-1] + constant_log_likelihood(k, n) + right[:, 1:]
    return at_level, left + right


def verdict_shares(posterior: LogPosterior, marginals: Marginals) -> Array:
    """Return the posterior probabilities (n_sets, 4) of the four explanations.

    The levels cover the rise, lie above it, lie below it, or there is no rise.
    """
    met = 1 - marginals.beyond.sum(axis=1, keepdims=True)
    curves = marginals.log_evidence[:, None] + _logarithm(np.hstack([met, marginals.beyond]))
    ceiling, guesses, constant = constant_evidence(posterior.counts, posterior.prior)
    with np.errstate(invalid="ignore"):
        # Levels lie on the upper asymptote if the rise is below them, on the guess rate if it is above.
        below = np.logaddexp(curves[:, 1], np.log(CEILING_WEIGHT) + ceiling)
        above = np.logaddexp(curves[:, 2], np.log(GUESSES_WEIGHT) + guesses)
        no_rise = np.log(CONSTANT_WEIGHT) + constant
        explanations = np.stack([curves[:, 0], below, above, no_rise], axis=1)
        total = logsumexp(explanations, axis=1, keepdims=True)
        return np.asarray(np.exp(explanations - total))


def constant_evidence(counts: Counts, prior: Prior) -> tuple[Array, Array, Array]:
    """Return the log evidence (n_sets,) of each asymptote and of any constant.

    The constant is uniform between the asymptotes if they are known. All evidences include the answers to catch trials.
    """
    k, n = counts.n_yes.sum(axis=1), counts.n_trials.sum(axis=1)
    alarms, correct = prior.n_false_alarms, prior.n_catch - prior.n_false_alarms
    low, high = prior.guess_rate or 0.0, 1 - (prior.lapse_rate or 0.0)
    share = np.asarray(betainc(k + 1, n - k + 1, high) - betainc(k + 1, n - k + 1, low))
    any_chance = betaln(k + 1, n - k + 1) + _logarithm(share)
    catch = np.zeros(len(counts))
    if prior.guess_rate is None:
        # Catch trials share the rate of the lower asymptote; otherwise they have a separate rate.
        catch = _log_mean_chance(None, prior.guess_beta, alarms, correct)
        guesses = _log_mean_chance(None, prior.guess_beta, k + alarms, n - k + correct)
    else:
        guesses = _log_mean_chance(prior.guess_rate, prior.guess_beta, k, n - k)
    ceiling = _log_mean_chance(prior.lapse_rate, prior.lapse_beta, n - k, k)
    return ceiling + catch, guesses, any_chance - np.log(high - low) + catch


def _log_mean_chance(rate: float | None, beta: float, k: Array, rest: Array) -> Array:
    if rate is None:
        a, b = k + 1, rest + beta
        share = np.asarray(betainc(a, b, LARGEST_RATE), dtype=np.float64)  # upper end of a free rate
        return betaln(a, b) + _logarithm(share) - log_rate_mass(beta)
    return np.asarray(xlogy(k, rate) + xlog1py(rest, -rate))


def _logarithm(x: Array) -> Array:
    """Return the logarithm, or minus infinity at 0 and below."""
    with np.errstate(divide="ignore"):
        return np.asarray(np.log(np.maximum(x, 0.0)), dtype=np.float64)
