"""Whether one interval of a forced choice was favoured, whatever it held."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri
from scipy.stats import chi2_contingency

from tactometry.arguments.require import expect

from ..arrays import Indices


@dataclass(frozen=True)
class IntervalBias:
    """How often each interval held the stimulus and was chosen.

    Parameters
    ----------
    n_target, n_chosen : tuple of int
        By interval, from the first.
    share_correct : tuple of float or None
        Correct answers by the interval that held the stimulus; None where none did.
    criterion : float or None
        Of two intervals: -(z(H) + z(F)) / 2, where H and F are the log-linear rates at which the second was chosen
        when it held the stimulus and when it did not; above 0 the first was favoured. Macmillan and Creelman, Detection
        Theory, 2nd ed. (2005), chapters 2 and 7.
    p : float or None
        Of a chi-square test of equal shares of correct answers in all intervals; None where it cannot be made.
    """

    n_target: tuple[int, ...]
    n_chosen: tuple[int, ...]
    share_correct: tuple[float | None, ...]
    criterion: float | None
    p: float | None


def interval_bias(targets: Sequence[int], responses: Sequence[int], n_intervals: int = 2) -> IntervalBias:
    """Sum up a forced choice from the columns `target` and `response` of its valid trials, each from 1.

    Raises
    ------
    InvalidParameter
        If there is no trial, or an interval that does not exist.

    >>> bias = interval_bias([1, 1, 2, 2] * 10, [1, 2, 2, 2] * 10)
    >>> bias.n_chosen, bias.share_correct, round(bias.criterion, 3)
    ((10, 30), (0.5, 1.0), -0.99)
    """
    table = _table(targets, responses, n_intervals)
    n_target, n_correct = table.sum(axis=1), table.diagonal()
    shares = tuple(float(right / n) if n else None for right, n in zip(n_correct, n_target, strict=True))
    counts = tuple(n_target.tolist()), tuple(table.sum(axis=0).tolist())
    return IntervalBias(*counts, shares, _criterion(table) if n_intervals == 2 else None, _equal_shares(table))


def _table(targets: Sequence[int], responses: Sequence[int], n_intervals: int) -> Indices:
    """Counts (target, response)."""
    numbers = f"{len(targets)} targets and {len(responses)} responses"
    expect(len(targets) == len(responses) > 0, "interval_bias", numbers, "as many of both, at least one")
    intervals = range(1, n_intervals + 1)
    table = np.zeros((n_intervals, n_intervals), dtype=np.int64)
    for n, (target, response) in enumerate(zip(targets, responses, strict=True)):
        known = target in intervals and response in intervals
        given = f"target {target} and response {response}"
        expect(known, f"interval_bias, trial {n}", given, f"intervals from 1 to {n_intervals}")
        table[target - 1, response - 1] += 1
    return table


def _criterion(table: Indices) -> float:
    second = (table[:, 1] + 0.5) / (table.sum(axis=1) + 1)
    return float(-ndtri(second).sum() / 2)


def _equal_shares(table: Indices) -> float | None:
    wrong_and_right = np.array([table.diagonal(), table.sum(axis=1) - table.diagonal()])
    if not (wrong_and_right.any(axis=0).all() and wrong_and_right.any(axis=1).all()):
        return None  # an empty row or column has no expected counts
    return float(chi2_contingency(wrong_and_right, correction=False).pvalue)
