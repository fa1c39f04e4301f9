"""Normal values that are known to lie between ends only: their chance, and weighted points of what they may be.

One value after the other is drawn between its ends given those before it (the simulator of Geweke, Hajivassiliou and
Keane; Genz and Bretz 2009, Computation of Multivariate Normal and t Probabilities, section 4.1), at points that fill
the cube evenly and are always the same. The chance of one value is exact, that of two right to five digits, a mean to a
few thousandths of its standard deviation.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.special import log_ndtr, ndtri_exp
from scipy.stats import qmc

from tactometry.psychometric import log1mexp

from ..arrays import Array

N_POINTS = 1024
"""A power of two, for which the sequence of Sobol is even."""
SEED = 20_171_101
"""Of its scrambling, so that the same data give the same numbers."""
SMALLEST = 1e-300


@dataclass(frozen=True)
class Between:
    """`log_chance` of values between their ends, and `points` (n, d) there with `weights` (n,) that sum to 1."""

    log_chance: float
    points: Array
    weights: Array


def between(mean: Array, covariance: Array, low: Array, high: Array) -> Between:
    """Of normal values of `mean` (d,) and `covariance` (d, d), between `low` and `high` (d,), which may be infinite.

    >>> found = between(np.zeros(1), np.eye(1), np.array([-np.inf]), np.zeros(1))
    >>> round(float(np.exp(found.log_chance)), 9), round(float(found.weights @ found.points[:, 0]), 2)
    (0.5, -0.8)
    """
    root, even = np.linalg.cholesky(covariance), _even(len(mean))
    steps, log_weights = np.zeros(even.shape), np.zeros(len(even))
    for j, sd in enumerate(np.diagonal(root)):
        middle = mean[j] + steps[:, :j] @ root[j, :j]
        steps[:, j], log_chance = _one(even[:, j], (low[j] - middle) / sd, (high[j] - middle) / sd)
        log_weights += log_chance
    largest = log_weights.max()
    weights = np.exp(log_weights - largest)  # a chance far out in a tail is below the floats
    log_mean = largest + np.log(weights.mean())
    return Between(float(log_mean), mean + steps @ root.T, weights / weights.sum())


@cache
def _even(n_dimensions: int) -> Array:
    points: Array = qmc.Sobol(n_dimensions, rng=np.random.default_rng(SEED)).random(N_POINTS)
    points.setflags(write=False)
    return points


def _one(even: Array, low: Array, high: Array) -> tuple[Array, Array]:
    """Standard normal values between ends, at even parts of their chance, and the logarithm of it; in the lower tail,
    which keeps its digits. Parts count from the low end also where the tail is flipped: else values jump as an end
    passes 0, and a search that moves it has no rest."""
    flipped = low > 0
    low, high = np.where(flipped, -high, low), np.where(flipped, -low, high)
    even = np.where(flipped, 1 - even, even)
    bottom, top = log_ndtr(low), log_ndtr(high)
    with np.errstate(invalid="ignore"):
        log_chance = top + log1mexp(np.maximum(top - bottom, SMALLEST))
    log_share = np.minimum(np.logaddexp(bottom, log_chance + np.log(even)), 0.0)
    values = np.clip(ndtri_exp(log_share), low, high)  # rounding may lead beyond an end
    return np.where(flipped, -values, values), log_chance
