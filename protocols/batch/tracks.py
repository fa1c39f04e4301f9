"""Many tracks of one rule at once: in machine code, or in products of matrices."""

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
"""Of all sets at a time: their weights stay near the processor."""


@dataclass(frozen=True, eq=False)
class TrackBatch:
    """What became of tracks.

    - `asked`, `levels`: (n_sets, n_trials). What the rule asked for, and what was delivered; NaN after a track's end.
    - `answers`: (n_sets, n_trials) of int. The outcomes, 1 or 0 of most rules, or `NOT_ASKED` after the end.
    - `endings`: (n_sets,) of int. As in `tactometry.protocols.procedures.stepping`; `ending` says one in words.
    - `thresholds`: (n_sets,). The rule's own estimates; NaN where there is none.
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
        """The length of each track, (n_sets,)."""
        return np.asarray((self.answers != NOT_ASKED).sum(axis=1))

    @classmethod
    def blank(cls, shape: tuple[int, ...]) -> Self:
        """Before the first answer."""
        n_sets = shape[0]
        answers, endings = np.full(shape, NOT_ASKED, dtype=np.int8), np.full(n_sets, GOES_ON, dtype=np.int8)
        asked, levels = np.full(shape, np.nan), np.full(shape, np.nan)
        return cls(asked, levels, answers, endings, np.full(n_sets, np.nan))

    def rows(self, sets: slice) -> Self:
        """A part of the sets, which shares their memory."""
        answers, endings = self.answers[sets], self.endings[sets]
        return type(self)(self.asked[sets], self.levels[sets], answers, endings, self.thresholds[sets])

    def ending(self, i: int) -> Ending | None:
        """How a track ended; None if it goes on."""
        return ending_of(int(self.endings[i]))


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

    - `rule`: One with a transition of plain numbers, or `Quest` or `QuestPlus`.
    - `criteria`: (n_sets, n_trials) or (n_sets, n_trials, n_outcomes - 1). As
      `tactometry.protocols.batch.answers.criteria` makes them; NaN is above all that is felt.
    - `table`: What is felt at a level; without one the level itself.
    - `orders`: (n_sets, n_drawn). As the rule's `orders` draws them; without them the given order for all.
    - `delivery`: What is delivered of a level; without it every level.

    Raises `InvalidParameter` if the rule is of another kind, there are no sets and trials or not the criteria of its
    outcomes, or tables and orders are neither one nor one for each set.

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
    """Return numbers with an array for each sequence: for each length of a tuple, numba would compile anew."""
    arrays = [np.array(value, dtype=np.float64) if isinstance(value, tuple) else value for value in numbers]
    return type(numbers)(*arrays) if arrays else ()


def weigh(rule: WeighingRule, criteria: Array, table: LevelTable | None, delivery: Delivery, made: TrackBatch) -> None:
    """Fill in a batch, of criteria (n_sets, n_trials, n_outcomes - 1)."""
    size = max(1, MOST_CELLS // rule.prior_state.weights.size)
    for first in range(0, len(criteria), size):
        sets = slice(first, first + size)
        _weigh(rule, criteria[sets], None if table is None else table.rows(sets), delivery, made.rows(sets))


def _weigh(rule: WeighingRule, criteria: Array, table: LevelTable | None, delivery: Delivery, made: TrackBatch) -> None:
    """Of sets that go on together; one that has ended is left out."""
    prior, going = rule.prior_state, np.arange(len(criteria))
    logs, weights = (np.tile(each, (len(criteria), 1)) for each in (prior.log_weights, prior.weights))
    n_trials = min(criteria.shape[1], rule.n_trials)
    for n in range(n_trials):
        asked = rule.places(logs, weights)
        levels = delivery(asked)
        felt = levels if table is None else table.at(levels, going)
        answers = (felt[:, None] > criteria[going, n]).sum(axis=1, dtype=np.int8)
        made.asked[going, n], made.levels[going, n], made.answers[going, n] = asked, levels, answers
        learnt = logs + rule.log_likelihoods(levels, answers)
        possible = np.isfinite(learnt.max(axis=1))
        learnt[~possible] = logs[~possible]  # what no cell allows leaves the weights of before
        logs, weights = normalised(learnt)
        codes = np.full(len(going), GOES_ON, dtype=np.int8)
        if rule.sd_stop is not None or n + 1 == n_trials:  # most trials need no look at the weights
            made.thresholds[going], _, codes = judged(rule, weights, n + 1)
        codes[~possible] = ABORTED
        made.endings[going] = codes
        left = codes == GOES_ON
        if not left.any():
            return
        if not left.all():
            going, logs, weights = going[left], logs[left], weights[left]
