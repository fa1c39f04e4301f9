"""What is preferred to what: worths of items from paired comparisons.

The log odds that the first of a pair is preferred are the difference of the two items' worths plus an effect of the
order (Bradley and Terry 1952, Biometrika 39, 324-345; order: Davidson and Beaver 1977, Biometrics 33, 693-702).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import permutations
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.special import ndtri

from tactometry.arguments.require import expect
from tactometry.errors import InvalidFile, nearest
from tactometry.trials.columns import stated_factors

from ..arrays import Array, Bools, Indices
from ..distributions import Student
from ..means import exact_interval, parts
from ..reading.rows import no_column, numbers_of, place_of
from ..reading.trials import Trials
from ..wording import level_of
from .answer_odds import logistic_fit
from .task_analysis import Results, TaskAnalysis

Texts = NDArray[np.str_]

TASK, SHARES, ORDER = "preference", "preference_shares", "first of the pair"
ALWAYS_FIRST = "which of a pair came first decided what was preferred: no finite worths"
ROBUST_FROM = 5
"""Participants from which standard errors count that the answers of one person are alike."""


class WorthStatus(StrEnum):
    OK = "ok"
    DISCONNECTED = "disconnected"


@dataclass(frozen=True)
class Worths:
    """A Bradley-Terry model.

    `worths` has a row per item: `item, n_pairs, n_preferred, worth, standard_error, low, high`; worths are logarithms
    of odds with mean 0, missing unless the status is ``ok``. `order` is how much the first of a pair gains, with the
    same columns. `disconnected`: some items were never preferred to some others, directly or through others, so that
    worths have no finite maximum (Ford 1957), or the order of a pair decided; `note` says which.
    """

    worths: pd.DataFrame
    order: pd.DataFrame
    status: WorthStatus
    note: str

    def probability(self, item: str, other: str) -> float:
        """That `item` is preferred to `other`, without an effect of the order.

        Raises
        ------
        InvalidParameter
            For an unknown item, or without finite worths.
        """
        worth_of = self.worths.set_index("item")["worth"]
        names = worth_of.index.tolist()
        for name in (item, other):
            expected = f"an item with a worth of {', '.join(names)}{nearest(str(name), names)}"
            is_known = name in names and self.status is WorthStatus.OK
            expect(is_known, "item", f"{name!r} ({self.status.value})", expected)
        return float(1 / (1 + np.exp(worth_of[other] - worth_of[item])))


def bradley_terry(
    first: Sequence[str],
    second: Sequence[str],
    preferred: Sequence[int],
    participants: Sequence[str] | None = None,
    *,
    interval: float = 0.95,
) -> Worths:
    """Worths of the items of paired comparisons, by maximum likelihood.

    Parameters
    ----------
    first, second : (n_trials,) sequence of str
        The items of each pair, in their order.
    preferred : (n_trials,) sequence of int
        1 where the first, 2 where the second was preferred.
    participants : (n_trials,) sequence of str, optional
        From 5 participants on standard errors are those of answers that go together within a participant (the sandwich
        estimator), intervals t with n - 1 degrees of freedom; else answers count as independent.

    Raises
    ------
    InvalidParameter
        For an answer other than 1 or 2, an item against itself, lengths that differ, or no trial.

    >>> found = bradley_terry(["a", "a", "b", "b", "c", "c"] * 4, ["b", "c", "a", "c", "a", "b"] * 4,
    ...     [1, 1, 2, 1, 1, 2, 1, 1, 2, 1, 2, 2, 1, 2, 2, 1, 2, 1, 2, 1, 1, 2, 2, 2])
    >>> (found.worths["worth"].round(2) + 0).tolist(), round(found.probability("a", "c"), 2)
    ([0.76, 0.0, -0.76], 0.82)
    """
    a, b = np.asarray(first, dtype=str), np.asarray(second, dtype=str)
    answer = np.asarray(preferred)
    _check(a, b, answer, participants)
    items, places = np.unique(np.stack([a, b]), return_inverse=True)
    places = places.reshape(2, -1)  # of the first and of the second item of each pair
    winner, loser = np.where(answer == 1, places, places[::-1])
    # An item that was never preferred has a count too: 0.
    numbers = {"n_pairs": np.bincount(places.ravel()), "n_preferred": np.bincount(winner, minlength=len(items))}
    counts = pd.DataFrame({"item": items.tolist(), **numbers})
    note = _gap(items, winner, loser)
    if note:
        return _without_worths(counts, note)
    fitted = _fit_worths(places, answer == 1, participants)
    if fitted is None:
        return _without_worths(counts, ALWAYS_FIRST)
    worth, error, df = fitted
    tail = (1 + interval) / 2
    reach = error * float(ndtri(tail) if np.isinf(df) else Student.ppf(tail, df))
    table = pd.DataFrame({"worth": worth, "standard_error": error, "low": worth - reach, "high": worth + reach})
    worths = pd.concat([counts, table.iloc[:-1]], axis=1)
    return Worths(worths, table.iloc[-1:].reset_index(drop=True), WorthStatus.OK, "")


def _without_worths(counts: pd.DataFrame, note: str) -> Worths:
    nothing = dict.fromkeys(("worth", "standard_error", "low", "high"), np.nan)
    return Worths(counts.assign(**nothing), pd.DataFrame([nothing]), WorthStatus.DISCONNECTED, note)


def _check(a: Texts, b: Texts, answer: NDArray[Any], participants: Sequence[str] | None) -> None:
    n = {len(a), len(b), len(answer)} | (set() if participants is None else {len(participants)})
    numbers = f"{', '.join(map(str, sorted(n)))} values"
    expect(len(n) == 1 and len(a) > 0, "first, second, preferred", numbers, "one a trial each")
    for row, (one, other, number) in enumerate(zip(a, b, answer, strict=True)):
        expect(number in (1, 2), f"preferred, row {row}", number, "1 (the first) or 2 (the second)")
        expect(one != other, f"first, second, row {row}", f"{one} against itself", "two items")


def _gap(items: Texts, winner: Indices, loser: Indices) -> str:
    """Which items were never preferred to which others, directly or through others (Ford's condition)."""
    from scipy.sparse.csgraph import connected_components  # slow to load

    beats = np.zeros((len(items), len(items)))
    beats[winner, loser] = 1
    n, group = connected_components(beats, directed=True, connection="strong")
    for low, high in permutations(range(n), 2):
        if not beats[np.ix_(group == low, group == high)].any():
            names = [", ".join(items[group == place]) for place in (low, high)]
            return f"{names[0]} never preferred to {names[1]}: no finite worths"
    return ""


def _fit_worths(
    places: Indices, prefers_first: Bools, participants: Sequence[str] | None
) -> tuple[Array, Array, float] | None:
    """Worths and the order's effect (n_items + 1,) with standard errors, and degrees of freedom (infinite: normal) of
    pairs of the items at these places (2, n_trials); None where the order parts the answers."""
    n_items = int(places.max()) + 1
    # worths have the mean 0: that of the last item is the opposite of the sum of the others
    basis = np.vstack([np.eye(n_items - 1), np.full(n_items - 1, -1.0)])
    n_trials = places.shape[1]
    design = np.column_stack([basis[places[0]] - basis[places[1]], np.ones(n_trials)])
    people = np.zeros(n_trials) if participants is None else np.asarray(participants, dtype=str)
    codes, _ = pd.factorize(people)
    n = int(codes.max()) + 1
    fitted = logistic_fit(design, prefers_first, codes if n >= ROBUST_FROM else None)
    if fitted is None:
        return None
    whole = np.zeros((n_items + 1, n_items))
    whole[:-1, :-1], whole[-1, -1] = basis, 1.0
    covariance = whole @ fitted[1] @ whole.T
    return whole @ fitted[0], np.sqrt(np.diagonal(covariance)), n - 1 if n >= ROBUST_FROM else np.inf


def preference_table(rows: pd.DataFrame, factors: Sequence[str]) -> pd.DataFrame:
    """Of the task's used rows, the worths of the items in each condition, then the order's effect.

    Raises
    ------
    InvalidFile
        If the table does not say which two items were compared.
    """
    _check_pairs(rows)
    varied = [name for name in factors if rows[name].nunique() > 1]
    tables = [_of_a_condition(dict(zip(varied, key, strict=True)), pairs) for key, pairs in parts(rows, varied)]
    return pd.concat(tables)


def _check_pairs(rows: pd.DataFrame) -> None:
    expected = "the two items of a preference in item and item_b, the one that came first in item"
    for name in ("item", "item_b"):
        if name not in rows.columns:
            raise InvalidFile(f"{rows['source'].iloc[0]}: {no_column(name, rows)}, expected {expected}")
    alike = (rows["item"] == rows["item_b"]) | (rows["item"] == "") | (rows["item_b"] == "")
    if alike.any():
        first = rows[alike].iloc[0]
        found = f"found the items {first['item']!r} and {first['item_b']!r}"
        raise InvalidFile(f"{place_of(rows[alike])}: {found}, expected {expected}")


def _of_a_condition(condition: dict[str, Any], rows: pd.DataFrame) -> pd.DataFrame:
    answers = numbers_of(rows["response"]).astype(int).tolist()
    model = bradley_terry(rows["item"].tolist(), rows["item_b"].tolist(), answers, rows["participant"].tolist())
    table = pd.concat([model.worths, model.order.assign(item=ORDER, n_pairs=len(rows))], ignore_index=True)
    return table.assign(note=model.note, **condition)[[*condition, *table.columns, "note"]]


def share_table(rows: pd.DataFrame, factors: Sequence[str]) -> pd.DataFrame:
    """Of the task's used rows, how often each item was preferred in each condition: its share of the pairs with it,
    with the exact 95 % interval of answers that are independent.

    Raises
    ------
    InvalidFile
        If the table does not say which two items were compared.
    """
    worths = preference_table(rows, factors)
    conditions = list(worths.columns[: worths.columns.get_loc("item")])
    counts = worths.loc[worths["item"] != ORDER, [*conditions, "item", "n_pairs", "n_preferred"]]
    low, high = exact_interval(counts["n_preferred"], counts["n_pairs"])
    share = counts["n_preferred"] / counts["n_pairs"]
    whole = counts.astype({"n_preferred": int})
    return whole.assign(share=share, share_low=low, share_high=high).reset_index(drop=True)


def _view(table: pd.DataFrame, trials: Trials, unit: str) -> pd.DataFrame:
    """Items with the unit of their factor, within each condition in the order of their numbers."""
    del unit
    factor = _compared_factor(trials)
    if not factor:
        return table
    ordered = table.sort_values("item", key=lambda item: numbers_of(item).fillna(float("inf")), kind="stable")
    conditions = list(table.columns[: table.columns.get_loc("item")])
    ordered = ordered.sort_values(conditions, kind="stable") if conditions else ordered
    return ordered.assign(item=[text if text == ORDER else level_of(factor, text) for text in ordered["item"]])


def _compared_factor(trials: Trials) -> str:
    """The factor whose levels each trial compares: its column holds nothing. Empty if not just one is so."""
    stated = stated_factors(list(trials.rows.columns))
    bare = [name for name in stated if not trials.rows[name].replace("", None).notna().any()]
    return bare[0] if len(bare) == 1 else ""


ANALYSIS = TaskAnalysis(
    "Participants told which of two they preferred",
    "with({data}, BradleyTerry2::BTm(as.integer(response == 1), factor(item, unique(c(item, item_b))), "
    "factor(item_b, unique(c(item, item_b)))))",
    results=Results(
        {TASK: preference_table, SHARES: share_table},
        "Paired preferences were fitted by the Bradley-Terry model with an effect of the order (Bradley & Terry 1952), "
        "with 95 % intervals that from five participants on count that a person's answers are alike.",
        works=(
            "Bradley, R. A., & Terry, M. E. (1952). Rank analysis of incomplete block designs: I. The method of "
            "paired comparisons. Biometrika, 39, 324-345.",
        ),
        title="Preferences",
        lead="Bradley-Terry worths (logarithms of odds, mean 0) with 95 % intervals; below them what the first of a "
        "pair gains.",
        in_terminal="preference (Bradley-Terry worths, 95 % interval)",
        view=_view,
    ),
)
