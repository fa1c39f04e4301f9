"""Direction and turning points of a finger along its path."""

from itertools import accumulate
from typing import NamedTuple

import numpy as np

from ...arrays import FloatArray


class Way(NamedTuple):
    """State of a finger's path up to a moment.

    Parameters
    ----------
    y_m : float
        Where it was last, noise left out (`without_jitter`).
    direction : float
        1 or -1, in which it moved last; 1 before it moves.
    turned_m : float
        Where it turned last, or began.
    pile, last_pile : float
        The share of the force at that turn and now, for a pile that remembers it.
    """

    y_m: float
    direction: float = 1.0
    turned_m: float = 0.0
    pile: float = 0.0
    last_pile: float = 0.0


def without_jitter(x_m: FloatArray, y_m: float, turn_m: float) -> FloatArray:
    """Return places (n,) that follow with a backlash of `turn_m`.

    Noise within `turn_m` turns no direction: the play operator of hysteresis (Krasnosel'skii and Pokrovskii 1989).

    >>> without_jitter(np.array([0.0, 2.0, 1.5, 2.5, 0.0]), 0.0, 1.0).tolist()
    [0.0, 1.0, 1.0, 1.5, 1.0]
    """
    if turn_m == 0:
        return x_m
    followed = accumulate(x_m.tolist(), lambda y, x: min(max(y, x - turn_m), x + turn_m), initial=y_m)
    return np.array(list(followed)[1:])


def directions_along(path_m: FloatArray, way: Way) -> FloatArray:
    """Return the last direction of motion, 1 or -1, at each place (n,).

    >>> directions_along(np.array([0.0, 0.0, -1.0, -1.0, 2.0]), Way(0.0)).tolist()
    [1.0, 1.0, -1.0, -1.0, 1.0]
    """
    steps = np.sign(np.diff(path_m, prepend=way.y_m))
    moved = np.where(steps != 0, np.arange(path_m.size), -1)
    last = np.maximum.accumulate(moved)
    return np.where(last >= 0, steps[np.maximum(last, 0)], way.direction)
