"""Shares of simulated sets, and how well they are known."""

from scipy.stats import binomtest

INTERVAL = 0.95


def share_interval(n_yes: int, n: int, coverage: float = INTERVAL) -> tuple[float, float]:
    """Clopper and Pearson's exact interval of a share (1934, Biometrika 26, 404).

    >>> low, high = share_interval(8, 10)
    >>> round(low, 4), round(high, 4)
    (0.4439, 0.9748)
    """
    found = binomtest(n_yes, n).proportion_ci(coverage, method="exact")
    return float(found.low), float(found.high)


def departure(n_yes: int, n: int, stated: float, alpha: float) -> int:
    """Whether so many of n are fewer (-1) or more (1) than a stated share allows, by the exact two-sided binomial test;
    0 where chance explains them.

    >>> departure(80, 100, 0.95, 1e-4), departure(93, 100, 0.95, 1e-4), departure(30, 100, 0.05, 1e-4)
    (-1, 0, 1)
    """
    if binomtest(n_yes, n, stated).pvalue >= alpha:
        return 0
    return 1 if n_yes > stated * n else -1
