"""Distributions of test statistics (scipy.stats is slow to load)."""

from typing import Any

import numpy as np
from scipy.special import chdtrc, chdtri, fdtrc, fdtri, gammaincinv, stdtr, stdtrit


class Student:
    """Student's t distribution with `df` degrees of freedom, also infinite."""

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
