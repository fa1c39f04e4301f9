"""The step function that fits best: where the answers change in one step, the steepness has no upper
bound."""

from dataclasses import dataclass

import numpy as np

from tactometry.psychometric import Shape

from ..arrays import Array, Bools
from .chances import weighted
from .counts import Counts
from .likelihood import GUESS, LAPSE, constant_log_likelihood, log_likelihood
from .mode import Mode

TOLERATED = 1.0
"""A difference of log-likelihoods that the data do not tell apart."""


@dataclass(frozen=True)
class StepFit:
    """The best step function, its place on the scale of `Counts.u`.

    `is_best`: no curve fits better. `is_between`: moreover the step lies between two levels, or does so at
    the price of a likelihood ratio below e^1, so that no level shows anything in between.
    """

    is_best: Bools
    is_between: Bools
    place: Array


def best_step(shape: Shape, counts: Counts, likeliest: Mode) -> StepFit:
    """The step with the asymptotes of the likeliest curve, and any rate at one level at most.

    Where it fits at least as well as the likeliest curve, the steepness has no upper bound. A step between
    two levels lies at their middle. One before or after all levels would be a constant rate, and no step.
    """
    at_level, between = _step_likelihoods(counts, likeliest)
    cut = np.arange(between.shape[1])  # cut i lies between the levels i - 1 and i
    has_both_sides = (cut > 0) & (cut < counts.n_levels[:, None])
    between = np.where(has_both_sides, between, -np.inf)
    best = np.maximum(at_level.max(axis=1), between.max(axis=1))
    is_best = best >= log_likelihood(shape, counts, likeliest.theta) - 1e-6
    is_between = between.max(axis=1) >= best - TOLERATED
    rows, gap = np.arange(len(counts)), between.argmax(axis=1)
    last = counts.u.shape[1] - 1
    middle = (counts.u[rows, np.maximum(gap - 1, 0)] + counts.u[rows, np.minimum(gap, last)]) / 2
    place = np.where(is_between, middle, counts.u[rows, at_level.argmax(axis=1)])
    return StepFit(is_best, is_best & is_between, place)


def _step_likelihoods(counts: Counts, likeliest: Mode) -> tuple[Array, Array]:
    """Steps at each level (n_sets, n_levels), and before, between and after the levels (n_sets, n_levels +
    1)."""
    k, n = counts.n_yes, counts.n_trials
    lapse, guess = likeliest.theta[:, LAPSE, None], likeliest.theta[:, GUESS, None]
    with np.errstate(divide="ignore"):
        below = _floored(weighted(k, np.log(guess)) + weighted(n - k, np.log1p(-guess)))
        above = _floored(weighted(k, np.log1p(-lapse)) + weighted(n - k, np.log(lapse)))
    none = np.zeros((len(counts), 1))
    left = np.hstack([none, np.cumsum(below, axis=1)])  # at i: the levels before i, on the lower asymptote
    right = np.hstack([np.cumsum(above[:, ::-1], axis=1)[:, ::-1], none])  # those from i on, on the upper one
    return left[:, :-1] + constant_log_likelihood(k, n) + right[:, 1:], left + right


def _floored(log_chance: Array) -> Array:
    return np.maximum(log_chance, -1e12)
