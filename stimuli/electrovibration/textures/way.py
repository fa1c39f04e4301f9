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
        Last position of the finger, without noise (`without_jitter`).
    direction : float
        Last direction of motion, 1 or -1; 1 before the finger moves.
    turned_m : float
        Position of the last turn, or of the start.
    pile, last_pile : float
        Share of the force at that turn and now, for a texture with a pile.
    """

    y_m: float
    direction: float = 1.0
    turned_m: float = 0.0
    pile: float = 0.0
    last_pile: float = 0.0


def without_jitter(x_m: FloatArray, y_m: float, turn_m: float) -> FloatArray:
    """Return positions (n,) that follow with a backlash of `turn_m`.

    Noise within `turn_m` does not change the direction. This is the play operator of hysteresis (Krasnosel'skii and
    Pokrovskii 1989).

    >>> without_jitter(np.array([0.0, 2.0, 1.5, 2.5, 0.0]), 0.0, 1.0).tolist()
    [0.0, 1.0, 1.0, 1.5, 1.0]
    """
    if turn_m == 0:
        return x_m
    followed = accumulate(x_m.tolist(), lambda y, x: min(max(y, x - turn_m), x + turn_m), initial=y_m)
    return np.array(list(followed)[1:])


def directions_along(path_m: FloatArray, way: Way) -> FloatArray:
    """Return the last direction of motion, 1 or -1, at each position (n,).

    >>> directions_along(np.array([0.0, 0.0, -1.0, -1.0, 2.0]), Way(0.0)).tolist()
    [1.0, 1.0, -1.0, -1.0, 1.0]
    """
    steps = np.sign(np.diff(path_m, prepend=way.y_m))
    moved = np.where(steps != 0, np.arange(path_m.size), -1)
    last = np.maximum.accumulate(moved)
    return np.where(last >= 0, steps[np.maximum(last, 0)], way.direction)
