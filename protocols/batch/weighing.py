"""Tracks of a rule that weighs a grid of functions: all sets at once, trial by trial, in products of matrices."""

import numpy as np
from numpy.typing import NDArray

from ..bayesian.weighing import WeighingRule, edges, normalised
from ..procedures.transition import ABORTED, CONVERGED, GOES_ON, TRIALS
from .answers import Array, LevelTable
from .delivery import Delivery
from .results import TrackBatch

MOST_CELLS = 400_000
"""Of all sets at a time: their weights stay near the processor."""


def weigh(rule: WeighingRule, criteria: Array, table: LevelTable | None, delivery: Delivery, made: TrackBatch) -> None:
    """Fill in a batch, of criteria (n_sets, n_trials, n_outcomes - 1)."""
    size = max(1, MOST_CELLS // rule.prior_state.weights.size)
    for first in range(0, len(criteria), size):
        sets = slice(first, first + size)
        _weigh(rule, criteria[sets], None if table is None else table.rows(sets), delivery, made.rows(sets))


def _weigh(rule: WeighingRule, criteria: Array, table: LevelTable | None, delivery: Delivery, made: TrackBatch) -> None:
    """Of sets that go on together; one that has ended is left out."""
    prior, going = rule.prior_state, np.arange(len(criteria))
    logs, weights = (np.tile(each, (len(criteria), 1)) for each in (prior.log_weights, prior.weights))
    n_trials = min(criteria.shape[1], rule.n_trials)
    for n in range(n_trials):
        asked = rule.places(logs, weights)
        levels = delivery(asked)
        felt = levels if table is None else table.at(levels, going)
        answers = (felt[:, None] > criteria[going, n]).sum(axis=1, dtype=np.int8)
        made.asked[going, n], made.levels[going, n], made.answers[going, n] = asked, levels, answers
        learnt = logs + rule.log_likelihoods(levels, answers)
        possible = np.isfinite(learnt.max(axis=1))
        learnt[~possible] = logs[~possible]  # what no cell allows leaves the weights of before
        logs, weights = normalised(learnt)
        codes = np.full(len(going), GOES_ON, dtype=np.int8)
        if rule.sd_stop is not None or n + 1 == n_trials:  # most trials need no look at the weights
            made.thresholds[going], codes = _judged(rule, weights, n + 1)
        codes[~possible] = ABORTED
        made.endings[going] = codes
        left = codes == GOES_ON
        if not left.any():
            return
        if not left.all():
            going, logs, weights = going[left], logs[left], weights[left]


def _judged(rule: WeighingRule, weights: Array, n_answers: int) -> tuple[Array, NDArray[np.int8]]:
    """Means of the threshold, and codes of endings, each (n_sets,)."""
    values = rule.thresholds
    marginals = weights.reshape(len(weights), len(values), -1).sum(axis=2)
    mean = marginals @ values
    sd = np.sqrt(np.einsum("st,st->s", marginals, (values - mean[:, None]) ** 2))
    at_end = TRIALS if n_answers >= rule.n_trials else GOES_ON
    codes = np.where(sd <= (-1.0 if rule.sd_stop is None else rule.sd_stop), CONVERGED, at_end).astype(np.int8)
    # At an end of the grid a small spread is the grid's own: the run is censored, however it ended.
    at_edge = edges(values, marginals)
    return mean, np.where((codes != GOES_ON) & (at_edge != GOES_ON), at_edge, codes)
