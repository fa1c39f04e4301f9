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
from .delivery import AS_ASKED, Delivery
from .results import TrackBatch
from .weighing import weigh


def tracks(
    rule: Rule[Any],
    criteria: Array,
    table: LevelTable | None = None,
    *,
    orders: Array | None = None,
    delivery: Delivery = AS_ASKED,
) -> TrackBatch:
    """A track for each row of criteria, of at most so many trials.

    A trial is answered with 1 where what is felt lies above its criterion; of several criteria as many as lie below it
    tell the outcome. Levels, answers and endings are those of the rule's own run, trial by trial.

    Parameters
    ----------
    rule : Rule
        One with a transition of plain numbers, or `Quest` or `QuestPlus`.
    criteria : (n_sets, n_trials) or (n_sets, n_trials, n_outcomes - 1) array
        As `tactometry.protocols.batch.answers.criteria` makes them; NaN is above all that is felt.
    table : LevelTable
        What is felt at a level; without one the level itself.
    orders : (n_sets, n_drawn) array
        As the rule's `orders` draws them; without them the given order for all.
    delivery : Delivery
        What is delivered of a level; without it every level.

    Raises
    ------
    InvalidParameter
        If the rule is of another kind, there are no sets and trials or not the criteria of its outcomes, or tables and
        orders are neither one nor one for each set.

    >>> from tactometry.protocols import Staircase
    >>> rule = Staircase(20.0, (4.0,), 0.0, 40.0, n_down=1)
    >>> tracks(rule, np.full((2, 4), 14.0)).levels.tolist()
    [[20.0, 16.0, 12.0, 16.0], [20.0, 16.0, 12.0, 16.0]]
    """
    drawn = criteria_of(rule, criteria, "(n_sets, n_trials)")
    _check(len(drawn), table, orders)
    made = TrackBatch.blank(drawn.shape[:2])
    if isinstance(rule, SteppingRule):
        _step(rule, drawn[..., 0], table, orders, delivery, made)
    elif isinstance(rule, WeighingRule):
        weigh(rule, drawn, table, delivery, made)
    else:
        raise InvalidParameter(f"tracks.rule: found {rule.name}, expected a rule with a transition, or of weights")
    made.thresholds[made.endings >= CENSORED] = np.nan
    return made


def _step(
    rule: SteppingRule[Any],
    criteria: Array,
    table: LevelTable | None,
    orders: Array | None,
    delivery: Delivery,
    made: TrackBatch,
) -> None:
    """Fill in a batch of a rule with a transition of plain numbers, in machine code."""
    from .loop import loop_of  # slow to load

    orders = rule.orders(1, None) if orders is None else orders
    felt = (np.zeros(0), np.zeros((1, 0))) if table is None else (table.levels, table.felt)
    marks = np.full(criteria.shape, np.nan)
    results = made.asked, made.levels, made.answers, marks, made.endings, made.thresholds
    loop_of(rule.transition)((_arrays(rule.numbers), orders), delivery.numbers, felt, criteria, results)


def criteria_of(rule: Rule[Any], criteria: Array, axes: str) -> Array:
    """With an axis for the criteria of a trial, one less than there are outcomes."""
    n_axes, found, n = axes.count(",") + 1, np.shape(criteria), rule.n_outcomes - 1
    whole = np.asarray(criteria)[..., None] if n == 1 and len(found) == n_axes else np.asarray(criteria)
    fits = whole.ndim == n_axes + 1 and min(whole.shape) > 0 and whole.shape[-1] == n
    expect(fits, "tracks.criteria", f"the shape {found}", axes if n == 1 else f"{axes[:-1]}, {n})")
    return whole


def _check(n_sets: int, table: LevelTable | None, orders: Array | None) -> None:
    for name, rows in (("table", None if table is None else table.felt), ("orders", orders)):
        fits = rows is None or len(rows) in (1, n_sets)
        expect(fits, f"tracks.{name}", f"{0 if rows is None else len(rows)} rows", f"1 or {n_sets}")


def _arrays(numbers: Numbers) -> tuple[Any, ...]:
    """With an array for each sequence: tuples of different length would be types of their own, compiled anew."""
    return tuple(np.array(value, dtype=np.float64) if isinstance(value, tuple) else value for value in numbers)
