"""Intervals of the means of conditions within participants: without what participants differ by in all conditions.

An interval between participants says where the mean of a condition may lie; it says little about the differences
between conditions, from which what participants share drops out. An interval within participants says that: Cousineau's
(2005, Tutorials in Quantitative Methods for Psychology 1, 42-45) with Morey's correction (2008, the same journal 4,
61-64), from values less the participant's own mean. Of two conditions the interval of the difference is sqrt(2) times
as wide; so two means differ where such intervals, shortened by sqrt(1 / 2), do not meet (Baguley 2012, Behavior
Research Methods 44, 158-175). Of more conditions both hold on average over the pairs.
"""

import numpy as np

from ..arrays import Array

DIFFERENCE = float(np.sqrt(0.5))
"""What shortens an interval so that two which do not meet tell a difference (Baguley 2012)."""


def within_variances(covariance: Array) -> Array:
    """The variance of each condition without what participants share, from the covariance (condition, condition);
    missing for one condition.

    >>> within_variances(np.array([[5.0, 4.0], [4.0, 6.0]])).tolist()
    [1.5, 1.5]
    """
    k = len(covariance)
    if k < 2:
        return np.full(k, np.nan)
    centre = np.eye(k) - 1 / k
    return np.asarray(np.diagonal(centre @ covariance @ centre) * k / (k - 1))
