"""Many tracks of one rule at once, in machine code or matrix products."""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from tactometry.arguments.require import expect
from tactometry.errors import InvalidParameter

from ..bayesian.weighing import WeighingRule, judged, normalised
from ..procedures.procedure import Ending, Rule
from ..procedures.stepping import ABORTED, CENSORED_ABOVE, GOES_ON, Numbers, SteppingRule, ending_of
from .answers import AS_ASKED, Array, Delivery, LevelTable

NOT_ASKED = -1
MOST_CELLS = 400_000
"""Largest number of weights at a time, so that they fit into the cache."""


@dataclass(frozen=True, eq=False)
class TrackBatch:
    """Results of tracks, one row each.

    - `asked`, `levels`: (n_sets, n_trials). Levels that the rule requested, and levels that were delivered. NaN after
      the end.
    - `answers`: (n_sets, n_trials). Outcomes, for most rules 1 or 0, or `NOT_ASKED` after the end.
    - `endings`: (n_sets,). Codes as in `tactometry.protocols.procedures.stepping`.
    - `thresholds`: (n_sets,). Estimates of the rule, or NaN.
    """

    asked: Array
    levels: Array
    answers: NDArray[np.int8]
    endings: NDArray[np.int8]
    thresholds: Array

    def __len__(self) -> int:
        return len(self.levels)

    @property
    def n_trials(self) -> NDArray[np.int64]:
        """Length of each track, (n_sets,)."""
        return np.asarray((self.answers != NOT_ASKED).sum(axis=1))

    @classmethod
    def blank(cls, shape: tuple[int, ...]) -> Self:
        """Return tracks of `shape` without answers."""
        return cls(
            asked=np.full(shape, np.nan),
            levels=np.full(shape, np.nan),
            answers=np.full(shape, NOT_ASKED, dtype=np.int8),
            endings=np.full(shape[0], GOES_ON, dtype=np.int8),
            thresholds=np.full(shape[0], np.nan),
        )

    def rows(self, sets: slice) -> Self:
        """Return views of the selected sets."""
        return type(self)(**{name: values[sets] for name, values in vars(self).items()})

    def ending(self, i: int) -> Ending | None:
        """Return the ending of a track, or None if it has not ended."""
        return ending_of(int(self.endings[i]))


def tracks(
    rule: Rule[Any],
    criteria: Array,
    table: LevelTable | None = None,
    *,
    orders: Array | None = None,
    delivery: Delivery = AS_ASKED,
) -> TrackBatch:
    """Run a track for each row of criteria, like a session would run it.

    The answer to a trial is the number of its criteria that the perceived level exceeds.

    - `rule`: Rule with a transition of plain numbers, or `Quest` or `QuestPlus`.
    - `criteria`: Shape (n_sets, n_trials) or (n_sets, n_trials, n_outcomes - 1). NaN is above every level.
    - `table`: Perceived level at each level. Without a table it is the level itself.
    - `orders`: Orders drawn by `orders` of the rule, (n_sets, n_drawn). Without them, all sets have the given order.

    Raises `InvalidParameter` if the rule is of another type, or the shapes do not match.

    >>> from tactometry.protocols import Staircase
    >>> rule = Staircase(20.0, (4.0,), 0.0, 40.0, n_down=1)
    >>> tracks(rule, np.full((2, 4), 14.0)).levels.tolist()
    [[20.0, 16.0, 12.0, 16.0], [20.0, 16.0, 12.0, 16.0]]
    """
    drawn, n = np.asarray(criteria), rule.n_outcomes - 1
    drawn = drawn[..., None] if n == 1 and drawn.ndim == 2 else drawn
    fits = drawn.ndim == 3 and min(drawn.shape) > 0 and drawn.shape[-1] == n
    shape = "(n_sets, n_trials)" if n == 1 else f"(n_sets, n_trials, {n})"
    expect(fits, "tracks.criteria", f"the shape {np.shape(criteria)}", shape)
    for name, rows in (("table", None if table is None else table.felt), ("orders", orders)):
        n_rows = len(drawn) if rows is None else len(rows)
        expect(n_rows in (1, len(drawn)), f"tracks.{name}", f"{n_rows} rows", f"1 or {len(drawn)}")
    made = TrackBatch.blank(drawn.shape[:2])
    if isinstance(rule, SteppingRule):
        _step(rule, drawn[..., 0], table, orders, delivery, made)
    elif isinstance(rule, WeighingRule):
        weigh(rule, drawn, table, delivery, made)
    else:
        raise InvalidParameter(f"tracks.rule: found {rule.name}, expected a rule with a transition or with weights")
    made.thresholds[made.endings >= CENSORED_ABOVE] = np.nan
    return made


def _step(
    rule: SteppingRule[Any],
    criteria: Array,
    table: LevelTable | None,
    orders: Array | None,
    delivery: Delivery,
    made: TrackBatch,
) -> None:
    """Fill in a batch in machine code."""
    from .loop import loop_of  # slow to load

    orders = rule.orders(1, None) if orders is None else orders
    felt = (np.zeros(0), np.zeros((1, 0))) if table is None else (table.levels, table.felt)
    marks = np.full(criteria.shape, np.nan)
    results = made.asked, made.levels, made.answers, marks, made.endings, made.thresholds
    loop_of(rule.transition)((_arrays(rule.numbers), orders), delivery.numbers, felt, criteria, results)


def _arrays(numbers: Numbers) -> tuple[Any, ...]:
    """Convert sequences to arrays, as numba compiles anew for each tuple length."""
    arrays = [np.array(value, dtype=np.float64) if isinstance(value, tuple) else value for value in numbers]
    return type(numbers)(*arrays) if arrays else ()


def weigh(rule: WeighingRule, criteria: Array, table: LevelTable | None, delivery: Delivery, made: TrackBatch) -> None:
    """Fill in a batch from criteria (n_sets, n_trials, n_outcomes - 1)."""
    size = max(1, MOST_CELLS // rule.prior_state.weights.size)
    for first in range(0, len(criteria), size):
        sets = slice(first, first + size)
        _weigh(rule, criteria[sets], None if table is None else table.rows(sets), delivery, made.rows(sets))


def _weigh(rule: WeighingRule, criteria: Array, table: LevelTable | None, delivery: Delivery, made: TrackBatch) -> None:
    """Fill in sets of equal length, each until its track ends."""
    prior, going = rule.prior_state, np.arange(len(criteria))
    logs, weights = (np.tile(each, (len(criteria), 1)) for each in (prior.log_weights, prior.weights))
    n_trials = min(criteria.shape[1], rule.n_trials)
    for n in range(n_trials):
        requested = rule.places(logs, weights)
        levels = delivery(requested)
        felt = levels if table is None else table.at(levels, going)
        answers = (felt[:, None] > criteria[going, n]).sum(axis=1, dtype=np.int8)
        made.asked[going, n], made.levels[going, n], made.answers[going, n] = requested, levels, answers
        learnt = logs + rule.log_likelihoods(levels, answers)
        possible = np.isfinite(learnt.max(axis=1))
        learnt[~possible] = logs[~possible]  # impossible answers leave the weights unchanged
        logs, weights = normalised(learnt)
        codes = np.full(len(going), GOES_ON, dtype=np.int8)
        if rule.sd_stop is not None or n + 1 == n_trials:  # most trials do not need the weights
            made.thresholds[going], _, codes = judged(rule, weights, n + 1)
        codes[~possible] = ABORTED
        made.endings[going] = codes
        left = codes == GOES_ON
        if not left.any():
            return
        if not left.all():
            going, logs, weights = going[left], logs[left], weights[left]
