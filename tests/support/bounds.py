"""Bounds of statistics, beyond which a sound sample lies with a probability of 1e-4."""

import numpy as np
from scipy.stats import binom, chi2

ALPHA = 1e-4


def is_rate(n_hits, p, n):
    """Return True if `n_hits` of n is within the binomial bounds for p."""
    return binom.ppf(ALPHA / 2, n, p) <= n_hits <= binom.isf(ALPHA / 2, n, p)


def within_sd(values, sd):
    """Return True if normal values are compatible with `sd`."""
    low, high = chi2.ppf([ALPHA / 2, 1 - ALPHA / 2], len(values) - 1)
    return low <= (len(values) - 1) * np.var(values, ddof=1) / sd**2 <= high
