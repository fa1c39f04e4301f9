"""Distributions and exact intervals computed with scipy.special.

scipy.stats is slow to load.
"""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import betaincinv, chdtrc, chdtri, fdtrc, fdtri, gammaincinv, stdtr, stdtrit

Array = NDArray[np.float64]


class Student:
    """Student's t distribution; `df` may be infinite."""

    @staticmethod
    def cdf(t: Any, df: Any) -> Any:
        return stdtr(df, t)

    @staticmethod
    def sf(t: Any, df: Any) -> Any:
        return stdtr(df, -t)

    @staticmethod
    def ppf(p: Any, df: Any) -> Any:
        return stdtrit(df, p)

    @staticmethod
    def isf(p: Any, df: Any) -> Any:
        return -stdtrit(df, p)


class Fisher:
    """Fisher's F distribution with `df1` and `df2` degrees of freedom."""

    @staticmethod
    def sf(f: Any, df1: Any, df2: Any) -> Any:
        return fdtrc(df1, df2, np.maximum(f, 0))

    @staticmethod
    def ppf(p: Any, df1: Any, df2: Any) -> Any:
        return fdtri(df1, df2, p)


class ChiSquare:
    """The chi-square distribution with `df` degrees of freedom."""

    @staticmethod
    def sf(x: Any, df: Any) -> Any:
        return chdtrc(df, np.maximum(x, 0))

    @staticmethod
    def ppf(p: Any, df: Any) -> Any:
        return 2 * gammaincinv(np.asarray(df) / 2, p)

    @staticmethod
    def isf(p: Any, df: Any) -> Any:
        return chdtri(df, p)


def exact_interval(n_yes: ArrayLike, n_trials: ArrayLike, interval: float = 0.95) -> tuple[Array, Array]:
    """Return exact intervals of rates (Clopper and Pearson 1934).

    >>> [end.round(3).tolist() for end in exact_interval([0, 5, 10], [10, 10, 10])]
    [[0.0, 0.187, 0.692], [0.308, 0.813, 1.0]]
    """
    k, n = (np.asarray(counts, dtype=np.float64) for counts in (n_yes, n_trials))
    tail = (1 - interval) / 2
    # The beta quantile is undefined without successes or without failures.
    low = np.where(k > 0, betaincinv(np.maximum(k, 1), n - k + 1, tail), 0.0)
    high = np.where(k < n, betaincinv(k + 1, np.maximum(n - k, 1), 1 - tail), 1.0)
    return low, high
