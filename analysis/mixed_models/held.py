"""Whether values and bounds hold every coefficient of a linear model, or the likelihood rises without end along one."""

import numpy as np
from scipy.optimize import linprog

from ..arrays import Array, Indices

ZERO = 1e-7


def endless_direction(ends: Array, x: Array) -> Array | None:
    """Coefficients (column,) along which no known value moves and every bound (row, 2) is kept ever better; None if
    there are none, and the likelihood has a finite maximum at any variance.

    It is the separation of Albert and Anderson (1984, Biometrika 71, 1-10), found by a linear programme.

    >>> endless_direction(np.array([[1.0, 1.0], [2.0, 2.0], [3.0, np.inf]]), np.array([[1.0, 0], [1, 0], [1, 1]]))
    array([0., 1.])
    """
    upward, downward = np.isposinf(ends[:, 1]), np.isneginf(ends[:, 0])
    one_sided = np.concatenate([x[upward & ~downward], -x[downward & ~upward]])
    if not len(one_sided):
        return None
    fixed = x[~upward & ~downward]
    kept, still = np.zeros(len(one_sided)), np.zeros(len(fixed))
    # A direction has any length: the bounds of 1 end the programme.
    best = linprog(-one_sided.sum(axis=0), A_ub=-one_sided, b_ub=kept, A_eq=fixed, b_eq=still, bounds=(-1, 1))
    if best.fun is None or best.fun >= -ZERO:
        return None
    return np.asarray(best.x, dtype=np.float64) + 0.0  # a zero without a sign


def leaves_no_error(ends: Array, x: Array, groups: Indices) -> bool:
    """Whether coefficients and participants' intercepts meet several known values of a participant exactly: no known
    value then tells the variance of errors, and the likelihood may rise without end as it vanishes."""
    known = ends[:, 0] == ends[:, 1]
    participants = np.unique(groups[known])
    if known.sum() <= len(participants):
        return False  # one value each: the variance between participants alone makes their density finite
    y, intercepts = ends[known, 0], np.equal.outer(groups[known], participants).astype(np.float64)
    every = np.concatenate([x[known], intercepts], axis=1)
    left = y - every @ np.linalg.lstsq(every, y, rcond=None)[0]
    return bool(np.abs(left).max() <= ZERO * np.abs(y).max())
