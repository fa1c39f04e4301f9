"""Signal detection theory: sensitivity, criterion, interval bias.

Green and Swets, Signal Detection Theory and Psychophysics (1966). Hautus 1995 for the log-linear correction.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.polynomial.hermite_e import hermegauss
from scipy.special import log_ndtr, ndtri

from tactometry.arguments.require import expect

from ..arrays import Indices

QUADRATURE_NODES = 80
LARGEST_D_PRIME = 12.0


class SensitivityIndex(NamedTuple):
    """d' and criterion c of a yes/no task, in SDs of the noise."""

    d_prime: float
    criterion: float


def yes_no_sensitivity(n_hits: int, n_signals: int, n_false_alarms: int, n_noises: int) -> SensitivityIndex:
    """Return d' = z(H) - z(F) and c = -(z(H) + z(F)) / 2.

    Rates use the log-linear correction (k + 0.5) / (n + 1).

    Raises
    ------
    InvalidParameter
        If a count is negative or above its number of trials, or there are no trials.
    """
    z_hit = z_score("n_hits", n_hits, "n_signals", n_signals)
    z_false_alarm = z_score("n_false_alarms", n_false_alarms, "n_noises", n_noises)
    return SensitivityIndex(z_hit - z_false_alarm, -(z_hit + z_false_alarm) / 2 + 0.0)  # avoid -0


def z_score(name: str, k: int, of: str, n: int) -> float:
    expect(n >= 1, of, n, "at least 1")
    expect(0 <= k <= n, name, k, f"a count from 0 to {of} ({n})")
    return float(ndtri((k + 0.5) / (n + 1)))


def forced_choice_chance(d_prime: float, n_alternatives: int) -> float:
    """Return the probability of a correct choice among m alternatives.

    It is the integral of phi(x - d') Phi(x)^(m - 1).

    Raises
    ------
    InvalidParameter
        If there are fewer than two alternatives or d' is not finite.
    """
    is_number = n_alternatives >= 2 and n_alternatives == int(n_alternatives)
    expect(is_number, "n_alternatives", n_alternatives, "a whole number from 2")
    expect(np.isfinite(d_prime), "d_prime", d_prime, "a finite number")
    x, weights = hermegauss(QUADRATURE_NODES)  # weight exp(-x^2 / 2), which is phi(x) except for the normalisation
    chances = np.exp((n_alternatives - 1) * log_ndtr(x + d_prime))
    return float(weights @ chances / weights.sum())


def forced_choice_sensitivity(rate_correct: float, n_alternatives: int) -> float:
    """Return the d' of an unbiased observer with this rate correct.

    This is the inverse of `forced_choice_chance`.

    Raises
    ------
    InvalidParameter
        If the rate has no d' between -12 and 12.
    """
    from scipy.optimize import brentq  # slow to load

    ends = (-LARGEST_D_PRIME, LARGEST_D_PRIME)
    low, high = (forced_choice_chance(end, n_alternatives) for end in ends)
    expect(low < rate_correct < high, "rate_correct", rate_correct, f"a rate between {low:.3g} and 1")
    return float(brentq(lambda d: forced_choice_chance(d, n_alternatives) - rate_correct, *ends, xtol=1e-13))


class IntervalBias(NamedTuple):
    """Stimuli, choices and correct answers by interval.

    `n_target` counts how often each interval contained the stimulus, `n_chosen` how often it was chosen.
    `share_correct` is the rate correct by interval of the stimulus, None without trials. `criterion`, for two
    intervals, is -(z(H) + z(F)) / 2. H and F are the log-linear rates at which the second interval was chosen with and
    without the stimulus. Above 0 the first interval was favoured (Macmillan and Creelman 2005, chapters 2 and 7). `p`
    belongs to a chi-square test of equal rates correct, None if it is undefined.
    """

    n_target: tuple[int, ...]
    n_chosen: tuple[int, ...]
    share_correct: tuple[float | None, ...]
    criterion: float | None
    p: float | None


def interval_bias(targets: Sequence[int], responses: Sequence[int], n_intervals: int = 2) -> IntervalBias:
    """Summarise a forced choice from targets and responses (from 1).

    Raises `InvalidParameter` if there are no trials, or an interval does not exist.
    """
    table = _choices(targets, responses, n_intervals)
    n_target, n_correct = table.sum(axis=1), table.diagonal()
    shares = tuple(float(right / n) if n else None for right, n in zip(n_correct, n_target, strict=True))
    counts = tuple(n_target.tolist()), tuple(table.sum(axis=0).tolist())
    second = (table[:, 1] + 0.5) / (n_target + 1)
    criterion = float(-ndtri(second).sum() / 2) if n_intervals == 2 else None
    return IntervalBias(*counts, shares, criterion, _equal_shares(table))


def _choices(targets: Sequence[int], responses: Sequence[int], n_intervals: int) -> Indices:
    """Return the counts of answers, shape (target, response)."""
    numbers = f"{len(targets)} targets and {len(responses)} responses"
    expect(len(targets) == len(responses) > 0, "interval_bias", numbers, "equal numbers, at least 1")
    answers = np.array([targets, responses])
    wrong = ~np.isin(answers, np.arange(1, n_intervals + 1)).all(axis=0)
    n = int(wrong.argmax())
    given = f"target {targets[n]} and response {responses[n]}"
    expect(not wrong.any(), f"interval_bias, trial {n}", given, f"intervals from 1 to {n_intervals}")
    table = np.zeros((n_intervals, n_intervals), dtype=np.int64)
    np.add.at(table, tuple(answers.astype(np.int64) - 1), 1)
    return table


def _equal_shares(table: Indices) -> float | None:
    from scipy.stats import chi2_contingency  # slow to load

    wrong_and_right = np.array([table.diagonal(), table.sum(axis=1) - table.diagonal()])
    if not (wrong_and_right.any(axis=0).all() and wrong_and_right.any(axis=1).all()):
        return None  # expected counts of 0
    # Yates's correction would make the test too conservative.
    return float(chi2_contingency(wrong_and_right, correction=False).pvalue)
