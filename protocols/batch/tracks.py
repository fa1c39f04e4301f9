"""Many tracks of one rule at once."""

from typing import Any

import numpy as np

from tactometry.arguments.require import expect
from tactometry.errors import InvalidParameter

from ..bayesian.weighing import WeighingRule
from ..procedures.procedure import Rule
from ..procedures.stepping import SteppingRule
from ..procedures.transition import CENSORED, Numbers
from .answers import Array, LevelTable
from .results import TrackBatch
from .weighing import weigh


def tracks(
    rule: Rule[Any], criteria: Array, table: LevelTable | None = None, *, orders: Array | None = None
) -> TrackBatch:
    """A track for each row of criteria, of at most so many trials.

    A trial is answered with 1 where what is felt lies above its criterion. Levels, answers and endings are those of the
    rule's own run, trial by trial.

    Parameters
    ----------
    rule : Rule
        One with a transition of plain numbers, or `Quest` or `QuestPlus` of two outcomes.
    criteria : (n_sets, n_trials) array
        As `tactometry.protocols.batch.answers.criteria` makes them; NaN is above all that is felt.
    table : LevelTable
        What is felt at a level; without one the level itself.
    orders : (n_sets, n_drawn) array
        As the rule's `orders` draws them; without them the given order for all.

    Raises
    ------
    InvalidParameter
        If the rule is of another kind, there are no sets and trials, or tables and orders are neither one nor one for
        each set.

    >>> from tactometry.protocols import Staircase
    >>> rule = Staircase(20.0, (4.0,), 0.0, 40.0, n_down=1)
    >>> tracks(rule, np.full((2, 4), 14.0)).levels.tolist()
    [[20.0, 16.0, 12.0, 16.0], [20.0, 16.0, 12.0, 16.0]]
    """
    _check(criteria, table, orders)
    made = TrackBatch.blank(criteria.shape)
    if isinstance(rule, SteppingRule):
        _step(rule, criteria, table, orders, made)
    elif isinstance(rule, WeighingRule) and rule.n_outcomes == 2:
        weigh(rule, criteria, table, made)
    else:
        raise InvalidParameter(f"tracks.rule: found {rule.name}, expected a rule with a transition, of two outcomes")
    made.thresholds[made.endings >= CENSORED] = np.nan
    return made


def _step(
    rule: SteppingRule[Any], criteria: Array, table: LevelTable | None, orders: Array | None, made: TrackBatch
) -> None:
    """Fill in a batch of a rule with a transition of plain numbers, in machine code."""
    from .loop import loop_of  # slow to load

    orders = rule.orders(1, None) if orders is None else orders
    felt = (np.zeros(0), np.zeros((1, 0))) if table is None else (table.levels, table.felt)
    results = made.levels, made.answers, np.full(criteria.shape, np.nan), made.endings, made.thresholds
    loop_of(rule.transition)((_arrays(rule.numbers), orders), felt, criteria, results)


def _check(criteria: Array, table: LevelTable | None, orders: Array | None) -> None:
    found = np.shape(criteria)
    expect(len(found) == 2 and min(found) > 0, "tracks.criteria", f"the shape {found}", "(n_sets, n_trials)")
    for name, rows in (("table", None if table is None else table.felt), ("orders", orders)):
        fits = rows is None or len(rows) in (1, len(criteria))
        expect(fits, f"tracks.{name}", f"{0 if rows is None else len(rows)} rows", f"1 or {len(criteria)}")


def _arrays(numbers: Numbers) -> tuple[Any, ...]:
    """With an array for each sequence: tuples of different length would be types of their own, compiled anew."""
    return tuple(np.array(value, dtype=np.float64) if isinstance(value, tuple) else value for value in numbers)
