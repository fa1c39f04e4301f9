"""The order of many blocks at once: who of the tracks is next, and which presentations are catch trials, by the laws of
one session's block (`protocols.block_state`)."""

from collections.abc import Callable
from typing import get_args

import numpy as np
from numpy.typing import NDArray

from tactometry.arguments.require import one_of

from ..block_state import Interleaving

Bools = NDArray[np.bool_]
Ints = NDArray[np.intp]
Turn = Callable[[Bools], Ints]
NOBODY = -1
CATCH = -1


def turns(interleaving: Interleaving, rng: np.random.Generator) -> Turn:
    """Who is next, (n_sets,), of the tracks that are open, (n_sets, n_tracks): any, or (``balanced``) each once in
    every round; `NOBODY` where none is.

    Raises
    ------
    InvalidParameter
        If the interleaving is unknown.

    >>> turn = turns("balanced", np.random.default_rng(1))
    >>> all_open = np.ones((1, 3), dtype=bool)
    >>> sorted(int(turn(all_open)[0]) for _ in range(3)), turn(~all_open).tolist()
    ([0, 1, 2], [-1])
    """
    one_of("turns.interleaving", interleaving, get_args(Interleaving))
    if interleaving == "random":
        return lambda open_: _nth(open_, rng.integers(np.maximum(open_.sum(axis=1), 1)))
    return _rounds(rng)


def _nth(open_: Bools, n: Ints) -> Ints:
    """The place of the open track with this number from 0."""
    return np.where(open_.any(axis=1), (open_.cumsum(axis=1) > n[:, None]).argmax(axis=1), NOBODY)


def _rounds(rng: np.random.Generator) -> Turn:
    left: Bools = np.zeros((0, 0), dtype=bool)
    places = np.zeros((0, 0))

    def turn(open_: Bools) -> Ints:
        nonlocal left, places
        if left.shape != open_.shape:
            left, places = np.zeros_like(open_), np.zeros(open_.shape)
        left &= open_
        over = ~left.any(axis=1)
        left[over], places[over] = open_[over], rng.random((int(over.sum()), open_.shape[1]))
        first = np.where(left, places, np.inf).argmin(axis=1)
        left[np.arange(len(left)), first] = False
        return np.where(open_.any(axis=1), first, NOBODY)

    return turn


def order_of(n_each: NDArray[np.integer], interleaving: Interleaving, rng: np.random.Generator) -> NDArray[np.int16]:
    """Whose presentations follow each other, (n_sets, n_presentations), of tracks with so many, (n_sets, n_tracks);
    `NOBODY` after the end of a block.

    >>> order_of(np.array([[2, 0], [0, 1]]), "random", np.random.default_rng(1)).tolist()
    [[0, 0], [1, -1]]
    """
    turn, left, sets = turns(interleaving, rng), np.array(n_each, dtype=np.intp), np.arange(len(n_each))
    order = np.full((len(left), int(left.sum(axis=1).max(initial=0))), NOBODY, dtype=np.int16)
    for n in range(order.shape[1]):
        next_ = turn(left > 0)
        order[:, n] = next_
        left[sets, next_] -= next_ != NOBODY
    return order


def catch_trials(shape: tuple[int, ...], n_trials: int, catch_rate: float, rng: np.random.Generator) -> Bools:
    """Whether each presentation of a track is a catch trial, (*shape, n_presentations) with room for so many trials: in
    each group of ``round(1 / catch_rate)`` exactly one is.

    >>> catch_trials((4,), 8, 0.2, np.random.default_rng(1)).sum(axis=1).tolist()
    [2, 2, 2, 2]
    """
    if catch_rate == 0:
        return np.zeros((*shape, n_trials), dtype=bool)
    n_group = max(round(1 / catch_rate), 1)
    caught = rng.integers(n_group, size=(*shape, -(-n_trials // (n_group - 1))))
    return np.asarray(caught[..., None] == np.arange(n_group)).reshape(*shape, -1)


def numbered(is_catch: Bools) -> Ints:
    """Which trial of its track each presentation is, from 0; `CATCH` of a catch trial.

    >>> numbered(np.array([False, True, False])).tolist()
    [0, -1, 1]
    """
    return np.where(is_catch, CATCH, (~is_catch).cumsum(axis=-1) - 1)
