"""Whether one interval of a forced choice was favoured, whatever it held."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tactometry.errors import InvalidParameter

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
    if not targets or len(targets) != len(responses):
        raise InvalidParameter(
            f"interval_bias: found {len(targets)} targets and {len(responses)} responses, expected as many of both, at "
            "least one"
        )
    table = np.zeros((n_intervals, n_intervals), dtype=np.int64)
    for n, (target, response) in enumerate(zip(targets, responses, strict=True)):
        if not (1 <= target <= n_intervals and 1 <= response <= n_intervals):
            raise InvalidParameter(
                f"interval_bias, trial {n}: found target {target} and response {response}, expected intervals from 1 "
                f"to {n_intervals}"
            )
        table[target - 1, response - 1] += 1
    return table


def _criterion(table: Indices) -> float:
    from scipy.special import ndtri

    second = (table[:, 1] + 0.5) / (table.sum(axis=1) + 1)
    return float(-ndtri(second).sum() / 2)


def _equal_shares(table: Indices) -> float | None:
    from scipy.stats import chi2_contingency

    right = table.diagonal()
    counts = np.array([right, table.sum(axis=1) - right])
    if (counts.sum(axis=0) == 0).any() or (counts.sum(axis=1) == 0).any():
        return None  # an empty row or column has no expected counts
    return float(chi2_contingency(counts, correction=False).pvalue)
