"""Many blocks of interleaved tracks at once."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactometry.arguments.require import expect

from ..block_state import BlockOptions, Interleaving
from ..procedures.procedure import Rule
from ..procedures.stepping import SteppingRule
from .answers import Array, LevelTable
from .delivery import AS_ASKED, Delivery
from .results import TrackBatch
from .tracks import criteria_of, tracks
from .turns import CATCH, Bools, Ints, catch_trials, numbered, order_of


@dataclass(frozen=True, eq=False)
class BlockBatch:
    """What became of blocks.

    Parameters
    ----------
    tracks : tuple of TrackBatch
        One for each track, of all sets.
    turns : (n_sets, n_presentations) array of int
        Whose presentation it is, by the place of the track; `NOBODY` after the end of a block.
    trials : (n_sets, n_presentations) array of int
        Which trial of its track it is, from 0; `CATCH` of a catch trial and after the end.
    """

    tracks: tuple[TrackBatch, ...]
    turns: NDArray[np.int16]
    trials: Ints

    def __len__(self) -> int:
        return len(self.turns)


def blocks(
    rule: Rule[Any],
    criteria: Array,
    rng: np.random.Generator,
    *,
    tables: Sequence[LevelTable] | None = None,
    interleaving: Interleaving = "random",
    catch_rate: float = 0.0,
    delivery: Delivery = AS_ASKED,
) -> BlockBatch:
    """Blocks of tracks of one rule that learn nothing of each other, in the random order of a session's block.

    What a track asks and is answered does not depend on when it is its turn: it is that of `tracks`.

    Parameters
    ----------
    rule, delivery
        As of `tactometry.protocols.batch.tracks.tracks`.
    criteria : (n_sets, n_tracks, n_trials) or (n_sets, n_tracks, n_trials, n_outcomes - 1) array
        As there. A catch trial has none: what is answered to it is not told.
    rng : Generator
        Draws the orders of the rule's levels, the turns and the catch trials.
    tables : sequence of LevelTable
        What is felt in each track; without them the level itself.
    interleaving, catch_rate
        As of `tactometry.protocols.BlockOptions`.

    Raises
    ------
    InvalidParameter
        As `tracks` does; or if there is not one table for each track, or an option is none of a block.

    >>> from tactometry.protocols import Staircase
    >>> rule = Staircase(20.0, (4.0,), 0.0, 40.0, n_trials=10, n_reversals=10)
    >>> made = blocks(rule, np.full((5, 2, 10), 14.0), np.random.default_rng(1))
    >>> len(made.tracks), made.turns.shape, np.bincount(made.turns[0]).tolist()
    (2, (5, 20), [10, 10])
    """
    BlockOptions(catch_rate=catch_rate, interleaving=interleaving)  # refuses what is none of a block
    drawn = criteria_of(rule, criteria, "(n_sets, n_tracks, n_trials)")
    n_sets, n_tracks, n_trials = drawn.shape[:3]
    felt = [None] * n_tracks if tables is None else list(tables)
    expect(len(felt) == n_tracks, "blocks.tables", f"{len(felt)} tables", f"{n_tracks}, one for each track")
    made = tuple(
        tracks(rule, drawn[:, n], table, orders=_orders(rule, n_sets, rng), delivery=delivery)
        for n, table in enumerate(felt)
    )
    is_catch = catch_trials((n_sets, n_tracks), n_trials, catch_rate, rng)
    turns = order_of(_lengths(np.stack([each.n_trials for each in made], axis=1), is_catch), interleaving, rng)
    return BlockBatch(made, turns, trials_of(turns, is_catch))


def _orders(rule: Rule[Any], n_sets: int, rng: np.random.Generator) -> Array | None:
    return rule.orders(n_sets, rng) if isinstance(rule, SteppingRule) else None


def _lengths(n_trials: NDArray[np.integer], is_catch: Bools) -> Ints:
    """Presentations of each track until its last trial, (n_sets, n_tracks)."""
    last = numbered(is_catch) == (n_trials - 1)[..., None]
    return np.where(n_trials > 0, last.argmax(axis=-1) + 1, 0)


def trials_of(turns: NDArray[np.int16], is_catch: Bools) -> Ints:
    """Which trial of its track each presentation of a block is, (n_sets, n_presentations)."""
    trials = numbered(is_catch)
    found = np.full(turns.shape, CATCH, dtype=np.intp)
    for track in range(is_catch.shape[1]):
        at = turns == track
        nth = at.cumsum(axis=1) - 1
        sets = np.nonzero(at)[0]
        found[at] = trials[sets, track, nth[at]]
    return found
