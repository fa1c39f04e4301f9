"""Worths of items estimated from paired comparisons (Bradley-Terry model).

The log odds that the first item of a pair is preferred are the difference between the worths of both items plus an
effect of the order (Bradley and Terry 1952, Biometrika 39, 324-345; order: Davidson and Beaver 1977, Biometrics 33,
693-702).
"""

import warnings
from collections.abc import Sequence
from itertools import permutations
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from tactometry.errors import InvalidFile
from tactometry.trials.columns import stated_factors

from ..arrays import Array, Bools, Indices
from ..distributions import Student, exact_interval
from ..means import parts
from ..reading.rows import no_column, numbers_of, place_of
from ..reading.trials import Trials
from ..wording import level_of
from .task_analysis import Results, TaskAnalysis

Texts = NDArray[np.str_]

TASK, SHARES, ORDER = "preference", "preference_shares", "first of the pair"
ALWAYS_FIRST = "no finite worths: the order within a pair determined every preference"
ROBUST_FROM = 5
"""Smallest number of participants for standard errors clustered by participant."""
MOST_LOG_ODDS = 16.0
"""Log odds (odds of 9e6) above which the predictors separate the answers."""
WORTH = ("worth", "standard_error", "low", "high")


def bradley_terry(
    first: Sequence[str],
    second: Sequence[str],
    preferred: Sequence[int],
    participants: Sequence[str] | None = None,
    *,
    interval: float = 0.95,
) -> pd.DataFrame:
    """Estimate the worths of items of paired comparisons.

    - `first`, `second`: First and second item of each pair, which must differ.
    - `preferred`: 1 if the first item was preferred, 2 if the second was preferred.
    - `participants`: With at least 5 participants, standard errors are clustered by participant (Liang and Zeger's
      sandwich estimator), and intervals use t with n - 1 degrees of freedom. Otherwise answers count as independent.

    Returns
    -------
    DataFrame
        `item, n_pairs, n_preferred, worth, standard_error, low, high, note`: one row per item, followed by the
        advantage of the first item. Worths are log odds with mean 0. They are missing if some items were never
        preferred to some others, directly or indirectly (Ford 1957), or if the order determined every preference.
        `note` is then the reason.

    >>> result = bradley_terry(["a", "a", "b", "b", "c", "c"] * 4, ["b", "c", "a", "c", "a", "b"] * 4,
    ...     [1, 1, 2, 1, 1, 2, 1, 1, 2, 1, 2, 2, 1, 2, 2, 1, 2, 1, 2, 1, 1, 2, 2, 2])
    >>> (result["worth"].round(2) + 0).tolist()
    [0.76, 0.0, -0.76, 0.0]
    """
    answer = np.asarray(preferred)
    items, places = np.unique(
        np.stack([np.asarray(first, dtype=str), np.asarray(second, dtype=str)]), return_inverse=True
    )
    places = places.reshape(2, -1)  # indices of the first and second item of each pair
    winner, loser = np.where(answer == 1, places, places[::-1])
    n_pairs = [*np.bincount(places.ravel()), len(answer)]
    n_preferred = [*np.bincount(winner, minlength=len(items)), np.nan]
    table = pd.DataFrame({"item": [*items.tolist(), ORDER], "n_pairs": n_pairs, "n_preferred": n_preferred})

    note = _gap(items, winner, loser)
    fitted = None if note else _fit_worths(places, answer == 1, participants)
    if fitted is None:
        return table.assign(**dict.fromkeys(WORTH, np.nan), note=note or ALWAYS_FIRST)
    worth, error, df = fitted
    reach = error * Student.ppf((1 + interval) / 2, df)
    return table.assign(worth=worth, standard_error=error, low=worth - reach, high=worth + reach, note="")


def _gap(items: Texts, winner: Indices, loser: Indices) -> str:
    """Return a note on items never preferred to some others (Ford 1957)."""
    from scipy.sparse.csgraph import connected_components  # slow to load

    beats = np.zeros((len(items), len(items)))
    beats[winner, loser] = 1
    n, group = connected_components(beats, directed=True, connection="strong")
    for low, high in permutations(range(n), 2):
        if not beats[np.ix_(group == low, group == high)].any():
            names = [", ".join(items[group == place]) for place in (low, high)]
            return f"no finite worths: {names[0]} never preferred to {names[1]}"
    return ""


def _fit_worths(
    places: Indices, prefers_first: Bools, participants: Sequence[str] | None
) -> tuple[Array, Array, float] | None:
    """Return worths with the effect of order, standard errors and df.

    `places` (2, n_trials) are the indices of both items of each pair. Degrees of freedom are infinite for normal
    intervals. Returns None if the order separates the answers.
    """
    import statsmodels.api as sm  # slow to load

    n_items, n_trials = int(places.max()) + 1, places.shape[1]
    # Worths have mean 0, so the last worth is minus the sum of the others.
    basis = np.vstack([np.eye(n_items - 1), np.full(n_items - 1, -1.0)])
    design = np.column_stack([basis[places[0]] - basis[places[1]], np.ones(n_trials)])
    people = np.zeros(n_trials) if participants is None else np.asarray(participants, dtype=str)
    codes, names = pd.factorize(people)
    is_robust = len(names) >= ROBUST_FROM
    errors: dict[str, Any] = {"cov_type": "cluster", "cov_kwds": {"groups": codes}} if is_robust else {}
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")  # ignore warnings about separated answers
        fit = sm.GLM(prefers_first.astype(float), design, family=sm.families.Binomial()).fit(tol=1e-14, **errors)
    if not np.abs(design @ fit.params).max() <= MOST_LOG_ODDS:
        return None
    whole = np.zeros((n_items + 1, n_items))
    whole[:-1, :-1], whole[-1, -1] = basis, 1.0
    covariance = whole @ fit.cov_params() @ whole.T
    return whole @ fit.params, np.sqrt(np.diagonal(covariance)), len(names) - 1 if is_robust else np.inf


def preference_table(rows: pd.DataFrame, factors: Sequence[str]) -> pd.DataFrame:
    """Return worths by condition, followed by the effect of order.

    Raises `InvalidFile` if the table does not state which items were compared.
    """
    _check_pairs(rows)
    varied = [name for name in factors if rows[name].nunique() > 1]
    tables = []
    for key, pairs in parts(rows, varied):
        condition: dict[str, Any] = dict(zip(varied, key, strict=True))
        answers = numbers_of(pairs["response"]).astype(int).tolist()
        people = pairs["participant"].tolist()
        table = bradley_terry(pairs["item"].tolist(), pairs["item_b"].tolist(), answers, people)
        tables.append(table.assign(**condition)[[*condition, *table.columns]])
    return pd.concat(tables)


def _check_pairs(rows: pd.DataFrame) -> None:
    expected = "the first item of each pair in 'item' and the second in 'item_b'"
    for name in ("item", "item_b"):
        if name not in rows.columns:
            raise InvalidFile(f"{rows['source'].iloc[0]}: {no_column(name, rows)}, expected {expected}")
    alike = (rows["item"] == rows["item_b"]) | (rows["item"] == "") | (rows["item_b"] == "")
    if alike.any():
        first = rows[alike].iloc[0]
        result = f"found the items {first['item']!r} and {first['item_b']!r}"
        raise InvalidFile(f"{place_of(rows[alike])}: {result}, expected {expected}")


def share_table(rows: pd.DataFrame, factors: Sequence[str]) -> pd.DataFrame:
    """Return the share of pairs in which each item was preferred.

    Raises `InvalidFile` as `preference_table`.
    """
    worths = preference_table(rows, factors)
    conditions = list(worths.columns[: worths.columns.get_loc("item")])
    counts = worths.loc[worths["item"] != ORDER, [*conditions, "item", "n_pairs", "n_preferred"]]
    low, high = exact_interval(counts["n_preferred"], counts["n_pairs"])
    share = counts["n_preferred"] / counts["n_pairs"]
    whole = counts.astype({"n_preferred": int})
    return whole.assign(share=share, share_low=low, share_high=high).reset_index(drop=True)


def _view(table: pd.DataFrame, trials: Trials, unit: str) -> pd.DataFrame:
    """Add units to items, and sort them by number."""
    del unit
    # The column of the compared factor is empty, as each trial compares two of its levels.
    stated = stated_factors(list(trials.rows.columns))
    bare = [name for name in stated if not trials.rows[name].replace("", None).notna().any()]
    if len(bare) != 1:
        return table
    (factor,) = bare
    ordered = table.sort_values("item", key=lambda item: numbers_of(item).fillna(float("inf")), kind="stable")
    conditions = list(table.columns[: table.columns.get_loc("item")])
    ordered = ordered.sort_values(conditions, kind="stable") if conditions else ordered
    return ordered.assign(item=[text if text == ORDER else level_of(factor, text) for text in ordered["item"]])


ANALYSIS = TaskAnalysis(
    "Participants reported which of two stimuli they preferred",
    "with({data}, BradleyTerry2::BTm(as.integer(response == 1), factor(item, unique(c(item, item_b))), "
    "factor(item_b, unique(c(item, item_b)))))",
    results=Results(
        {TASK: preference_table, SHARES: share_table},
        "Paired preferences were fitted by the Bradley-Terry model with an effect of the order (Bradley & Terry 1952), "
        "with 95 % intervals; with five or more participants, standard errors were clustered by participant.",
        works=(
            "Bradley, R. A., & Terry, M. E. (1952). Rank analysis of incomplete block designs: I. The method of "
            "paired comparisons. Biometrika, 39, 324-345.",
        ),
        title="Preferences",
        lead="Bradley-Terry worths (log odds, mean 0) with 95 % intervals. The last row is the advantage of the first "
        "item of a pair.",
        in_terminal="preference (Bradley-Terry worths, 95 % interval)",
        view=_view,
    ),
)
