"""Whether answers hold a threshold: the posterior probability that the levels meet the rise of the function.

Four explanations are weighed. The levels meet the rise (some level lies between its 0.05 and 0.95 points, or levels lie
on both sides of it); all levels lie on the upper asymptote; all lie on the lower one; or the chance is some other
constant. The fit's own priors let the threshold lie up to half a range outside of the levels. To ask fairly, it may
also be farther away than any curve of the fit, where only an asymptote is left to tell, or the function too shallow to
rise: the evidence of such constant chances has a closed form. The ratios are Bayes factors (Kass and Raftery 1995,
Journal of the American Statistical Association 90, 773-795). They depend on the likelihood alone, not on how the levels
were chosen, so that tracks that aim at one part of the function are not punished for it; and answers that no curve
made reach a Bayes factor of b for a curve in at most one of b cases, whatever the procedure (Markov's inequality).
"""

import numpy as np
from scipy.special import betainc, betaln, logsumexp

from ..arrays import Array
from .chances import weighted
from .counts import Counts
from .marginals import Marginals
from .prior import LARGEST_RATE, Prior

CEILING_WEIGHT, GUESSES_WEIGHT, CONSTANT_WEIGHT = 0.3, 3.5, 0.05
"""Before the data, of a threshold so far below, or above, the levels that they tell nothing, and of no rise at all,
beside 1 for the curves of the fit. Unverified defaults: with them the census (docs/analysis.md) keeps the shares of
wrong statuses. Guesses weigh more, because by luck they rise with the level more often than answers at a ceiling do."""


def verdict_shares(counts: Counts, prior: Prior, found: Marginals) -> Array:
    """Posterior probabilities (n_sets, 4): the levels meet the rise; all lie above it; all lie below it; there is none.
    NaN for sets without a posterior."""
    met = 1 - found.beyond.sum(axis=1, keepdims=True)
    curves = found.log_evidence[:, None] + _logarithm(np.hstack([met, found.beyond]))
    ceiling, guesses, constant = constant_evidence(counts, prior)
    with np.errstate(invalid="ignore"):
        # A rise below all levels leaves them on the ceiling, one above all levels leaves them to guesses.
        below = np.logaddexp(curves[:, 1], np.log(CEILING_WEIGHT) + ceiling)
        above = np.logaddexp(curves[:, 2], np.log(GUESSES_WEIGHT) + guesses)
        explanations = np.stack([curves[:, 0], below, above, np.log(CONSTANT_WEIGHT) + constant], axis=1)
        return np.asarray(np.exp(explanations - logsumexp(explanations, axis=1, keepdims=True)))


def constant_evidence(counts: Counts, prior: Prior) -> tuple[Array, Array, Array]:
    """Log evidence (n_sets,) of the upper asymptote alone for all answers, of the lower one, and of a chance that is
    uniform between the two where they are known; with that of the answers to catch trials."""
    k, n = counts.n_yes.sum(axis=1), counts.n_trials.sum(axis=1)
    alarms, correct = prior.n_false_alarms, prior.n_catch - prior.n_false_alarms
    low, high = prior.guess_rate or 0.0, 1 - (prior.lapse_rate or 0.0)
    share = np.asarray(betainc(k + 1, n - k + 1, high) - betainc(k + 1, n - k + 1, low))
    any_chance = _log_beta(k + 1, n - k + 1) + _logarithm(share)
    if prior.guess_rate is None:
        # Answers to catch trials are guesses: beside a lower asymptote they share its rate, else they have one of
        # their own.
        catch = _log_mean_chance(prior, None, alarms, correct)
        guesses = _log_mean_chance(prior, None, k + alarms, n - k + correct)
    else:
        catch = np.zeros(len(counts))
        guesses = _log_mean_chance(prior, prior.guess_rate, k, n - k)
    ceiling = _log_mean_chance(prior, prior.lapse_rate, n - k, k)
    return ceiling + catch, guesses, any_chance - np.log(high - low) + catch


def _log_mean_chance(prior: Prior, rate: float | None, k: Array, rest: Array) -> Array:
    """Log chance of k answers at a rate and the rest at its complement, averaged over the prior of a free rate."""
    if rate is None:
        a, b = k + 1, rest + prior.rate_beta
        return _log_beta(a, b) + _logarithm(np.asarray(betainc(a, b, LARGEST_RATE))) - prior.log_rate_mass
    with np.errstate(divide="ignore"):
        return np.asarray(weighted(k, np.log(rate)) + weighted(rest, np.log1p(-rate)))


def _log_beta(a: Array, b: Array) -> Array:
    return np.asarray(betaln(a, b), dtype=np.float64)


def _logarithm(x: Array) -> Array:
    """Minus infinity for what rounding has brought to 0 or below."""
    with np.errstate(divide="ignore"):
        return np.asarray(np.log(np.maximum(x, 0.0)), dtype=np.float64)
