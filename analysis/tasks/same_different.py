"""Same-different sensitivity (Macmillan and Creelman 2005, chapter 9)."""

from collections.abc import Sequence
from math import sqrt

import numpy as np
import pandas as pd
from scipy.special import ndtr, ndtri

from ..reading.rows import is_catch, numbers_of
from ..reading.trials import Trials
from .signal_detection import LARGEST_D_PRIME, z_score
from .task_analysis import R_OF_LEVEL, Results, TaskAnalysis

TASK = "same_different"
SENSITIVITIES = {"d_prime_differencing": "d′ differencing", "d_prime_independent": "d′ independent"}
COUNTED = ("n_hits", "n_different", "n_false_alarms", "n_same")
COUNTS = {"hits": ("n_hits", "n_different"), "false alarms": ("n_false_alarms", "n_same")}


def differencing_sensitivity(n_hits: int, n_different: int, n_false_alarms: int, n_same: int) -> float:
    """Return d' under the differencing rule.

    The observer answers "different" if two sensations differ by more than a criterion k.

    The false-alarm rate is 2 Phi(-k / sqrt 2), the hit rate Phi((d' - k) / sqrt 2) + Phi((-d' - k) / sqrt 2). Both
    rates use the log-linear correction. d' is 0 if different pairs are not called different more often than same pairs.

    Raises `InvalidParameter` if a count is negative or above its number of trials, or there are no trials.
    """
    from scipy.optimize import brentq  # slow to load

    hit, false_alarm = (ndtr(z) for z in _rates(n_hits, n_different, n_false_alarms, n_same))
    if hit <= false_alarm:
        return 0.0
    k = -sqrt(2) * ndtri(false_alarm / 2)

    def excess(d_prime: float) -> float:
        upper, lower = ndtr((d_prime - k) / sqrt(2)), ndtr((-d_prime - k) / sqrt(2))
        return float(upper + lower - hit)

    return float(brentq(excess, 0, 4 * LARGEST_D_PRIME))


def independent_sensitivity(n_hits: int, n_different: int, n_false_alarms: int, n_same: int) -> float:
    """Return d' under the independent-observation rule.

    The observer classifies each sensation separately. d' = 2 z((1 + sqrt(2 p - 1)) / 2), where p = Phi((z(H) - z(F)) /
    2) is the unbiased rate correct.

    Raises `InvalidParameter` as `differencing_sensitivity`.
    """
    hit, false_alarm = _rates(n_hits, n_different, n_false_alarms, n_same)
    correct = ndtr((hit - false_alarm) / 2)
    above_chance = max(2 * correct - 1, 0.0)  # d' is 0 for fewer hits than false alarms
    return 2 * float(ndtri((1 + sqrt(above_chance)) / 2))


def _rates(n_hits: int, n_different: int, n_false_alarms: int, n_same: int) -> tuple[float, float]:
    """Return the hit and false-alarm rates as standard normal deviates."""
    hit = z_score("n_hits", n_hits, "n_different", n_different)
    return hit, z_score("n_false_alarms", n_false_alarms, "n_same", n_same)


def same_different_table(rows: pd.DataFrame, factors: Sequence[str]) -> pd.DataFrame:
    """Return counts and d' by participant, condition and level.

    Without a d', `note` is the reason.
    """
    rows = rows.assign(different=numbers_of(rows["response"]), is_same=is_catch(rows))
    keys = ["participant", *factors]
    other = rows[~rows["is_same"]].groupby([*keys, "level"])["different"].agg(n_hits="sum", n_different="size")
    same = rows[rows["is_same"]].groupby(keys)["different"].agg(n_false_alarms="sum", n_same="size")
    counts = other.reset_index().merge(same.reset_index(), how="left", on=keys)
    counts = counts.fillna(dict.fromkeys(COUNTED, 0)).astype(dict.fromkeys(COUNTED, np.int64))
    sensitivities = [_sensitivities(*numbers) for numbers in counts[list(COUNTED)].values.tolist()]
    return counts.join(pd.DataFrame(sensitivities))


def _sensitivities(n_hits: int, n_different: int, n_false_alarms: int, n_same: int) -> dict[str, object]:
    # With identical answers, the log-linear d' would depend only on the numbers of trials.
    are_alike = n_hits + n_false_alarms in (0, n_different + n_same)
    note = "all answers alike" if are_alike else ""
    if not n_same:
        note = "no same pairs"
    counts = n_hits, n_different, n_false_alarms, n_same
    return {name: np.nan if note else rule(*counts) for name, rule in RULES.items()} | {"note": note}


RULES = {"d_prime_differencing": differencing_sensitivity, "d_prime_independent": independent_sensitivity}


def _view(table: pd.DataFrame, trials: Trials, unit: str) -> pd.DataFrame:
    """Format counts as ``3 of 4``, and rename columns for readers."""
    del trials
    for name, (count, of) in COUNTS.items():
        shares = [f"{k} of {n}" for k, n in zip(table[count], table[of], strict=True)]
        table = table.assign(**{count: shares}).rename(columns={count: name}).drop(columns=of)
    return table.rename(columns=SENSITIVITIES | ({"level": f"level ({unit})"} if unit else {}))


ANALYSIS = TaskAnalysis(
    "Participants reported whether a standard and a comparison stimulus differed",
    R_OF_LEVEL,
    results=Results(
        {TASK: same_different_table},
        "Sensitivity in same-different trials was computed under the differencing and the independent-observation rule "
        "(Macmillan & Creelman 2005), with the log-linear correction.",
        works=("Macmillan, N. A., & Creelman, C. D. (2005). Detection theory: A user's guide (2nd ed.). Erlbaum.",),
        title="Same or different",
        lead="d' by participant, condition and level under the differencing and the independent-observation rule.",
        in_terminal="same or different (d′ under both rules)",
        view=_view,
    ),
)
