"""Compiled loop over sets and trials for a transition."""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from tactometry.compiled import called, entry, sources

from ..procedures import stepping as codes
from ..procedures.stepping import GOES_ON, Transition
from .answers import nearest


def _felt(level: float, levels: Any, felt: Any) -> Any:
    """Interpolate like `numpy.interp`, exact at the table's levels."""
    n = len(levels)
    if n == 0:
        return level
    right = np.searchsorted(levels, level)
    if right == n:
        return felt[n - 1]
    if right == 0 or levels[right] == level:
        return felt[right]
    share = (level - levels[right - 1]) / (levels[right] - levels[right - 1])
    return felt[right - 1] + share * (felt[right] - felt[right - 1])


@cache
def loop_of(transition: Transition) -> Callable[..., None]:
    """Compile the loop of a transition once and cache it on disk."""
    start: Any = called(transition.start)
    level_of: Any = called(transition.level)
    after: Any = called(transition.after)
    ending_of: Any = called(transition.ending)
    threshold_of: Any = called(transition.threshold)
    felt_at, delivered_at = called(_felt), called(nearest)
    stamp = sources(start, level_of, after, ending_of, threshold_of, delivered_at, codes.ending_of)

    def loop(rule, output, table, criteria, results):  # type: ignore[no-untyped-def]
        _ = stamp
        (numbers, orders), (step, low, high), (places, felt) = rule, output, table
        requested, levels, answers, marks, endings, thresholds = results
        n_sets, n_trials = criteria.shape
        for i in range(n_sets):
            order, row, n = orders[i % len(orders)], felt[i % len(felt)], 0
            state, ending = start(numbers, order), GOES_ON
            while ending == GOES_ON and n < n_trials:
                requested[i, n] = level_of(numbers, order, state)
                levels[i, n] = delivered_at(requested[i, n], step, low, high)
                answers[i, n] = felt_at(levels[i, n], places, row) > criteria[i, n]
                n += 1
                state, marks[i, n - 1] = after(numbers, order, state, answers[i, :n], levels[i, :n])
                ending = ending_of(numbers, order, state, answers[i, :n])
            endings[i], thresholds[i] = ending, threshold_of(marks[i, :n])

    return entry(loop)
