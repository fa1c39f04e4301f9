"""Many tracks of one rule at once."""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from tactometry.arguments.require import expect

from ..procedures.procedure import Ending
from ..procedures.stepping import SteppingRule
from ..procedures.transition import CENSORED, GOES_ON, Numbers, ending_of
from .answers import Array, LevelTable

NOT_ASKED = -1


@dataclass(frozen=True, eq=False)
class TrackBatch:
    """What became of tracks.

    Parameters
    ----------
    levels : (n_sets, n_trials) array
        NaN after a track's end.
    answers : (n_sets, n_trials) array of int
        1, 0, or `NOT_ASKED` after the end.
    endings : (n_sets,) array of int
        As in `tactometry.protocols.procedures.transition`; `ending` says one in words.
    thresholds : (n_sets,) array
        The rule's own estimates; NaN where there is none.
    """

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
        return cls(np.full(shape, np.nan), answers, endings, np.full(n_sets, np.nan))

    def ending(self, i: int) -> Ending | None:
        """How a track ended; None if it goes on."""
        return ending_of(int(self.endings[i]))


def tracks(
    rule: SteppingRule[Any], criteria: Array, table: LevelTable | None = None, *, orders: Array | None = None
) -> TrackBatch:
    """A track for each row of criteria, of at most so many trials.

    A trial is answered with 1 where what is felt lies above its criterion. Levels, answers and endings are those of the
    rule's own run, trial by trial.

    Parameters
    ----------
    rule : SteppingRule
    criteria : (n_sets, n_trials) array
        As `tactometry.protocols.batch.answers.criteria` makes them; NaN is above all that is felt.
    table : LevelTable
        What is felt at a level; without one the level itself.
    orders : (n_sets, n_drawn) array
        As the rule's `orders` draws them; without them the given order for all.

    Raises
    ------
    InvalidParameter
        If there are no sets and trials, or tables and orders are neither one nor one for each set.

    >>> from tactometry.protocols import Staircase
    >>> rule = Staircase(20.0, (4.0,), 0.0, 40.0, n_down=1)
    >>> tracks(rule, np.full((2, 4), 14.0)).levels.tolist()
    [[20.0, 16.0, 12.0, 16.0], [20.0, 16.0, 12.0, 16.0]]
    """
    from .loop import loop_of  # slow to load

    _check(criteria, table, orders)
    made = TrackBatch.blank(criteria.shape)
    orders = rule.orders(1, None) if orders is None else orders
    felt = (np.zeros(0), np.zeros((1, 0))) if table is None else (table.levels, table.felt)
    marks = np.full(criteria.shape, np.nan)
    results = made.levels, made.answers, marks, made.endings, made.thresholds
    loop_of(rule.transition)((_arrays(rule.numbers), orders), felt, criteria, results)
    made.thresholds[made.endings >= CENSORED] = np.nan
    return made


def _check(criteria: Array, table: LevelTable | None, orders: Array | None) -> None:
    found = np.shape(criteria)
    expect(len(found) == 2 and min(found) > 0, "tracks.criteria", f"the shape {found}", "(n_sets, n_trials)")
    for name, rows in (("table", None if table is None else table.felt), ("orders", orders)):
        fits = rows is None or len(rows) in (1, len(criteria))
        expect(fits, f"tracks.{name}", f"{0 if rows is None else len(rows)} rows", f"1 or {len(criteria)}")


def _arrays(numbers: Numbers) -> tuple[Any, ...]:
    """With an array for each sequence: tuples of different length would be types of their own, compiled anew."""
    return tuple(np.array(value, dtype=np.float64) if isinstance(value, tuple) else value for value in numbers)
