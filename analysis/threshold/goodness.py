"""Goodness of fit, tested by simulation.

Each statistic is compared with its parametric bootstrap, in which every draw is fitted again (Wichmann and Hill 2001,
Perception & Psychophysics 63, 1293-1313). With one or two answers per level the deviance is not chi-squared
distributed. Drawing stops when `ENOUGH` draws of a data set are as extreme as the answers (Besag and Clifford 1991,
Biometrika 78, 301-304).
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tactometry.psychometric import Shape

from ..arrays import Array, Bools, Indices, Rows
from .counts import Counts
from .likelihood import GUESS, log_chances, saturated_log_likelihood, weighted
from .log_posterior import LogPosterior
from .mode import climb

STATISTICS = ("deviance", "residual_level_z", "residual_order_z", "dispersion")
TWO_SIDED = np.array([False, True, True, False])
N_STATISTICS = len(STATISTICS)
ENOUGH = 6
"""Number of draws as extreme as the answers after which drawing stops; p then has a relative error of a third."""
ROUNDS = (20, 20, 40, 80, 160, 320, 359)
N_DRAWS = sum(ROUNDS)
MOST_AT_ONCE = 1_000_000
"""Largest number of values drawn at once (8 MB)."""
SMALL_DECREMENT = 1e-3
"""Decrement in log density at which the fit of a draw stops, far below differences between deviances."""
FEEDBACK = np.array([1.0, 1.0, 1.3, 1.3])
"""With adaptive levels, residuals over time vary more about the fitted function than those of draws at fixed levels.
Trend and dispersion are therefore divided by these factors before comparison. They were measured for staircases, QUEST
and QUEST+ of 40 to 80 trials (1.1 to 1.35); for other procedures they are unverified defaults."""
EQUAL = 1e-9
SMALLEST_VARIANCE = 1e-12


@dataclass(frozen=True)
class Sequences(Rows):
    """Answers (n_sets, n_stretches, n_levels), counted in stretches of trials.

    A stretch is a number of consecutive trials; the levels are those of `Counts`.
    """

    n_yes: Array
    n_trials: Array


@dataclass(frozen=True)
class Goodness:
    """Statistics and their p (n_sets, 4), in the order of `STATISTICS`.

    The first is the deviance. The second is the standardised curvature of the residuals over the levels; above 0 there
    are more "yes" or correct answers than predicted at both ends and fewer in the middle. The third is the standardised
    trend of the residuals over time; above 0 there are more such answers than predicted at the end. The fourth is the
    dispersion: squared residuals of the stretches divided by their binomial variance, near 1 for independent answers.
    It is the mean of two dispersions. The dispersion of plain residuals increases if criterion or threshold drift. The
    dispersion of residuals weighted by the predicted rate minus its mean increases with runs of lapses or guesses.
    """

    statistics: Array
    p: Array


def goodness(
    posterior: LogPosterior, theta: Array, answers: Sequences, follows: Bools, rng: np.random.Generator
) -> Goodness:
    """Test the fits of a posterior at the modes `theta` (n_sets, 4).

    `follows` (n_sets,) is True for data sets with adaptive levels.
    """
    observed = statistics(posterior.shape, posterior.counts, theta, answers)
    compared = observed / np.where(follows[:, None], FEEDBACK, 1.0)
    tally = _Tally(np.zeros(observed.shape, dtype=np.int64), np.zeros(observed.shape, dtype=np.int64))
    for n_draws in ROUNDS:
        for chosen in _portions(tally.is_open(), n_draws * answers.n_trials[0].size):
            drawn = _draws(posterior[chosen], theta[chosen], answers[chosen], n_draws, rng)
            tally.add(chosen, _is_as_extreme(drawn, compared[chosen][:, None]))
    return Goodness(observed, tally.p())


def statistics(shape: Shape, counts: Counts, theta: Array, answers: Sequences) -> Array:
    """Return the four statistics of each data set, (n_sets, 4)."""
    log_yes, log_no = log_chances(shape, counts.u, theta)
    psi, variance = np.exp(log_yes), np.exp(log_yes + log_no)  # psi (1 - psi), precise even if psi rounds to 1
    k, n = counts.n_yes, counts.n_trials
    log_likelihood = (weighted(k, log_yes) + weighted(n - k, log_no)).sum(axis=1)
    deviance = saturated_log_likelihood(counts) - log_likelihood
    off = answers.n_yes - answers.n_trials * psi[:, None]
    spread = answers.n_trials * variance[:, None]
    away = psi - _mean(psi, n * variance)
    bend = _bend(counts.u, k - n * psi, n * variance)
    trend = _trend(off.sum(axis=2), spread.sum(axis=2))
    plain, by_rate = _dispersion(off, spread, np.ones_like(away)), _dispersion(off, spread, away)
    dispersion = (plain + by_rate) / 2
    return np.stack((2 * deviance, bend, trend, dispersion), axis=1)


def _bend(u: Array, off: Array, variance: Array) -> Array:
    """Return z of residuals weighted by the square of the level."""
    away = u - _mean(u, variance)
    square = _mean(away**2, variance)
    line = _mean(away**3, variance) / np.maximum(square, SMALLEST_VARIANCE)
    return _z(away**2 - square - line * away, off, variance)


def _trend(off: Array, variance: Array) -> Array:
    """Return z of the residuals weighted by time minus its mean."""
    time = np.arange(off.shape[1], dtype=np.float64)[None]
    return _z(time - _mean(time, variance), off, variance)


def _mean(x: Array, weight: Array) -> Array:
    total = np.maximum(weight.sum(axis=1, keepdims=True), SMALLEST_VARIANCE)
    return np.asarray((weight * x).sum(axis=1, keepdims=True) / total)


def _z(weight: Array, off: Array, variance: Array) -> Array:
    of_sum = np.maximum((variance * weight**2).sum(axis=1), SMALLEST_VARIANCE)
    return np.asarray((off * weight).sum(axis=1) / np.sqrt(of_sum))


def _dispersion(off: Array, spread: Array, weight: Array) -> Array:
    """Return squared residuals of stretches over their expectation."""
    squares = np.square((off * weight[:, None]).sum(axis=2)).sum(axis=1)
    expected = (spread * weight[:, None] ** 2).sum(axis=(1, 2))
    return np.asarray(squares / np.maximum(expected, SMALLEST_VARIANCE))


def _draws(posterior: LogPosterior, theta: Array, answers: Sequences, n_draws: int, rng: np.random.Generator) -> Array:
    """Return statistics (n_sets, n_draws, 4) of refitted simulations."""
    shape, counts = posterior.shape, posterior.counts
    same = np.repeat(np.arange(len(counts)), n_draws)
    chance = np.minimum(np.exp(log_chances(shape, counts.u, theta)[0]), 1.0)
    trials = answers.n_trials.astype(np.int64)
    size = (len(counts), n_draws, *trials.shape[1:])
    yes = rng.binomial(trials[:, None], chance[:, None, None], size)
    drawn = Sequences(yes.reshape(-1, *trials.shape[1:]).astype(np.float64), answers.n_trials[same])
    alarms = rng.binomial(posterior.prior.n_catch.astype(np.int64)[same], theta[same, GUESS]).astype(np.float64)
    redrawn = posterior.redrawn(same, drawn.n_yes.sum(axis=1), alarms)
    refitted = climb(redrawn, theta[same], small_decrement=SMALL_DECREMENT)
    return statistics(shape, redrawn.counts, refitted.theta, drawn).reshape(len(counts), n_draws, N_STATISTICS)


def _is_as_extreme(drawn: Array, observed: Array) -> Bools:
    drawn, observed = (np.where(TWO_SIDED, np.abs(x), x) for x in (drawn, observed))
    return np.asarray(drawn >= observed - EQUAL * np.maximum(1.0, np.abs(observed)))


@dataclass(frozen=True)
class _Tally:
    """Numbers of draws and of extreme draws for each p, shape (n_sets, 4)."""

    n_drawn: Indices
    n_extreme: Indices

    def is_open(self) -> Indices:
        """Return the indices of data sets that need more draws for any p."""
        return np.flatnonzero((self.n_extreme < ENOUGH).any(axis=1))

    def add(self, sets: Indices, extreme: Bools) -> None:
        """Count `extreme` (n_sets, n_draws, 4) draws until each p is complete."""
        before = self.n_extreme[sets]
        so_far = before[:, None] + np.cumsum(extreme, axis=1)
        # The stopping rule requires that later draws of the same round are ignored.
        counted = np.minimum((so_far < ENOUGH).sum(axis=1) + 1, extreme.shape[1])
        is_open = before < ENOUGH
        self.n_drawn[sets] += np.where(is_open, counted, 0)
        self.n_extreme[sets] = np.where(is_open, np.minimum(so_far[:, -1], ENOUGH), before)

    def p(self) -> Array:
        """Return the sequential Monte Carlo p of Besag and Clifford."""
        closed = self.n_extreme >= ENOUGH
        share = self.n_extreme / np.maximum(self.n_drawn, 1)
        return np.where(closed, share, (self.n_extreme + 1) / (self.n_drawn + 1))


def _portions(sets: Indices, n_numbers: int) -> Iterator[Indices]:
    """Split data sets into parts that draw at most `MOST_AT_ONCE` values."""
    size = max(1, MOST_AT_ONCE // n_numbers)
    yield from (sets[start : start + size] for start in range(0, len(sets), size))
