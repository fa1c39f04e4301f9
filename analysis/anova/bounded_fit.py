"""Analysis-of-variance model fitted to values and bounds by likelihood.

Each participant's values are normal, with a mean for each condition and a variance for each stratum (participants,
participants by each factor, participants by each interaction). If all values are known, the model equals the analysis
of variance. A bound contributes the probability of its interval (Tobin 1958, Econometrica 26, 24-36). The fit uses
expectation maximisation (Dempster, Laird and Rubin 1977), with the observed information by Louis (1982, Journal of the
Royal Statistical Society B 44, 226-233). Values within bounds are drawn in sequence, each conditional on the earlier
ones (Geweke, Hajivassiliou and Keane; Genz and Bretz 2009, Computation of Multivariate Normal and t Probabilities,
section 4.1), at fixed quasi-random points. The probability of one bounded value is exact; that of two is accurate to
five digits.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from scipy.special import log_ndtr, ndtri_exp

from tactometry.psychometric import log1mexp

from ..arrays import Array, Bools, Indices
from .design import contrasts, effect_places

TOLERANCE = 1e-8
"""Convergence tolerance of a step: in standard deviations for means, in logarithms for variances."""
MAX_STEPS = 2000
LEAST_VARIANCE = 1e-12
"""Variances below this fraction of the largest one count as zero."""
LOG_TWO_PI = float(np.log(2 * np.pi))
N_POINTS = 1024
"""Number of Sobol points (the sequence requires a power of two)."""
SEED = 20_171_101
"""Seed of the scrambled sequence, so that equal data yield equal results."""
SMALLEST = 1e-300


@dataclass(frozen=True)
class BoundedValues:
    """Values (participant, cell) between `low` and `high`.

    Known values have equal ends, missing values infinite ends. `group` (participant,) is the index of each
    participant's group. `n_levels` is the number of levels of each factor; cells vary fastest along the last factor.
    """

    low: Array
    high: Array
    group: Indices
    n_levels: tuple[int, ...]

    @property
    def known(self) -> Bools:
        return np.asarray(self.low == self.high)

    @property
    def sizes(self) -> Array:
        """Number of participants in each group."""
        return np.bincount(self.group).astype(np.float64)

    @cached_property
    def strata(self) -> tuple[Array, ...]:
        """Orthonormal contrasts (contrast, cell) by stratum, participants first."""
        places = [(), *effect_places(len(self.n_levels))]
        return tuple(contrasts(self.n_levels, of_stratum) for of_stratum in places)

    def matrix(self, variances: Array) -> Array:
        """Return the covariance (cell, cell) from the variances of the strata."""
        pairs = zip(variances, self.strata, strict=True)
        return np.asarray(sum(variance * stratum.T @ stratum for variance, stratum in pairs), dtype=np.float64)


@dataclass(frozen=True)
class Points:
    """Weighted possible values (n, cell) of a participant."""

    values: Array
    weights: Array
    log_probability: float = 0.0


@dataclass(frozen=True)
class BoundedFit:
    """Maximum-likelihood fit.

    `means` has the shape (group, cell), `variances` (stratum,). `covariance` is that of the means, row by row, followed
    by the log variances (0 for strata without error). `moments` (group, cell, cell) are the covariances of the values
    within each group.
    """

    data: BoundedValues
    means: Array
    variances: Array
    covariance: Array
    moments: Array
    log_likelihood: float
    converged: bool

    @property
    def model(self) -> Array:
        """Covariance (cell, cell) of a participant's values."""
        return self.data.matrix(self.variances)

    @property
    def pooled(self) -> Array:
        """Covariance (cell, cell) of the values within groups."""
        return np.asarray(np.tensordot(self.data.sizes - 1, self.moments, axes=1) / self.df)

    @property
    def of_means(self) -> Array:
        """Covariance of the means (group * cell), row by row."""
        n = self.means.size
        return self.covariance[:n, :n]

    @property
    def df(self) -> int:
        """Degrees of freedom of participants within groups."""
        return len(self.data.low) - len(self.means)

    @property
    def inflation(self) -> float:
        """Ratio of the variances by restricted likelihood to those by likelihood."""
        return len(self.data.low) / self.df

    @property
    def has_error(self) -> Bools:
        """Return True for each stratum whose variance exceeds rounding error."""
        return _above_rounding(self.variances)

    def df_of(self, stratum: int) -> float:
        """Return the degrees of freedom of a stratum, reduced for bounds."""
        if not self.has_error[stratum]:
            return float(self.df)
        place = self.means.size + stratum
        # 2 variance^2 / Var(variance), where `covariance` is that of the log variance.
        df = 2 / float(self.covariance[place, place]) / len(self.data.strata[stratum])
        return min(df / self.inflation, float(self.df))


def fit_bounded(data: BoundedValues) -> BoundedFit:
    """Fit the model to values with a standard deviation of about 1.

    Raises `numpy.linalg.LinAlgError` if the search leaves the range of floating-point numbers.
    """
    ends = np.where(np.isfinite(data.low), data.low, data.high)
    cell_means = np.nanmean(np.where(data.known, data.low, np.nan), axis=0)
    start = np.where(np.isfinite(ends), ends, cell_means)
    means, variances = _maximum(data, [Points(row[None], np.ones(1)) for row in start])
    change = np.inf
    for _ in range(MAX_STEPS):
        new_means, new_variances = _maximum(data, _points(data, means, variances))
        change_of_means = float(np.abs(new_means - means).max() / np.sqrt(new_variances.max()))
        change = max(change_of_means, float(np.abs(np.log(new_variances / variances)).max()))
        means, variances = new_means, new_variances
        if change < TOLERANCE:
            break

    points = _points(data, means, variances)
    moments = _second_moments(data, points, means) / np.maximum(data.sizes - 1, 1)[:, None, None]
    covariance = _inverse_of_free(_information(data, points, means, variances), variances)
    log_likelihood = float(sum(of_one.log_probability for of_one in points))
    return BoundedFit(data, means, variances, covariance, moments, log_likelihood, change < TOLERANCE)


def _maximum(data: BoundedValues, points: Sequence[Points]) -> tuple[Array, Array]:
    """Return the means and variances expected under the weights (M step)."""
    expected = np.stack([of_one.weights @ of_one.values for of_one in points])
    members = np.equal.outer(np.arange(len(data.sizes)), data.group)
    means = members @ expected / data.sizes[:, None]
    second = _second_moments(data, points, means).sum(axis=0) / len(expected)
    # Mean variance of the contrasts C of a stratum: trace(C M C') / number of contrasts.
    variances = np.array([np.sum((stratum @ second) * stratum) / len(stratum) for stratum in data.strata])
    return means, np.maximum(variances, LEAST_VARIANCE * variances.max())


def _second_moments(data: BoundedValues, points: Sequence[Points], means: Array) -> Array:
    """Return sums of squares and products about means (group, cell, cell)."""
    sums = np.zeros((len(means), *[means.shape[1]] * 2))
    for of_one, place in zip(points, data.group, strict=True):
        away = of_one.values - means[place]
        sums[place] += (away * of_one.weights[:, None]).T @ away
    return sums


def _points(data: BoundedValues, means: Array, variances: Array) -> list[Points]:
    covariance = data.matrix(variances)
    rows = zip(data.low, data.high, means[data.group], strict=True)
    return [_points_of_one(low, high, mean, covariance) for low, high, mean in rows]


def _points_of_one(low: Array, high: Array, mean: Array, covariance: Array) -> Points:
    """Return points of the unknown values, conditional on the known values."""
    known = low == high
    of_known = covariance[np.ix_(known, known)]
    both = covariance[np.ix_(known, ~known)]
    away = low[known] - mean[known]
    square = float(away @ np.linalg.solve(of_known, away))
    log_determinant = float(np.linalg.slogdet(of_known)[1])
    log_density = -0.5 * (log_determinant + square + len(of_known) * LOG_TWO_PI)
    if known.all():
        return Points(low[None], np.ones(1), log_density)

    regression = np.linalg.solve(of_known, both).T
    spread = np.asarray(covariance[np.ix_(~known, ~known)] - regression @ both, dtype=np.float64)
    others = truncated_normal(mean[~known] + regression @ away, spread, low[~known], high[~known])
    values = np.empty((len(others.weights), len(low)))
    values[:, known], values[:, ~known] = low[known], others.values
    return Points(values, others.weights, log_density + others.log_probability)


def _above_rounding(variances: Array) -> Bools:
    return np.asarray(variances > LEAST_VARIANCE * variances.max())


def _inverse_of_free(information: Array, variances: Array) -> Array:
    """Invert the information; variances of 0 are fixed, with covariance 0."""
    free = np.concatenate([np.full(len(information) - len(variances), True), _above_rounding(variances)])
    covariance = np.zeros(information.shape)
    covariance[np.ix_(free, free)] = np.linalg.inv(information[np.ix_(free, free)])
    return covariance


def _information(data: BoundedValues, points: Sequence[Points], means: Array, variances: Array) -> Array:
    """Return the negative Hessian in means and log variances."""
    n_cells = means.shape[1]
    whole = np.zeros((means.size + len(variances),) * 2)
    for of_one, place in zip(points, data.group, strict=True):
        of_group = np.arange(place * n_cells, (place + 1) * n_cells)
        at = np.concatenate([of_group, np.arange(means.size, len(whole))])
        away = of_one.values - means[place]
        whole[np.ix_(at, at)] += _information_of_one(data, away, of_one.weights, variances)
    return whole


def _information_of_one(data: BoundedValues, away: Array, weights: Array, variances: Array) -> Array:
    n, inverse = away.shape[1], data.matrix(1 / variances)
    strata = zip(data.strata, variances, strict=True)
    by_stratum = [away @ stratum.T @ stratum / variance for stratum, variance in strata]
    halves = np.stack([0.5 * np.sum(pull * away, axis=1) for pull in by_stratum], axis=1)
    # Louis: the variance of the gradient over the possible values is the missing information.
    gradient = np.hstack([away @ inverse, halves])
    gradient = gradient - weights @ gradient
    information = -(gradient * weights[:, None]).T @ gradient
    information[:n, :n] += inverse
    for place, pull in enumerate(by_stratum, n):
        information[:n, place] += weights @ pull
        information[place, :n] += weights @ pull
        information[place, place] += weights @ halves[:, place - n]
    return np.asarray(information)


def truncated_normal(mean: Array, covariance: Array, low: Array, high: Array) -> Points:
    """Return weighted points of a truncated normal distribution."""
    root, even = np.linalg.cholesky(covariance), _even(len(mean))
    steps, log_weights = np.zeros(even.shape), np.zeros(len(even))
    for j, sd in enumerate(np.diagonal(root)):
        middle = mean[j] + steps[:, :j] @ root[j, :j]
        bottom, top = (low[j] - middle) / sd, (high[j] - middle) / sd
        steps[:, j], log_probability = _standard_between(even[:, j], bottom, top)
        log_weights += log_probability
    largest = log_weights.max()
    weights = np.exp(log_weights - largest)  # subtract the largest, as probabilities far in a tail underflow
    log_mean = largest + np.log(weights.mean())
    return Points(mean + steps @ root.T, weights / weights.sum(), float(log_mean))


@cache
def _even(n_dimensions: int) -> Array:
    from scipy.stats import qmc  # slow to load

    points: Array = qmc.Sobol(n_dimensions, rng=np.random.default_rng(SEED)).random(N_POINTS)
    points.setflags(write=False)
    return points


def _standard_between(even: Array, low: Array, high: Array) -> tuple[Array, Array]:
    """Return quantiles and log probability of a truncated standard normal.

    The computation uses the lower tail for precision. Quantiles count from the lower end even if the tail is flipped:
    otherwise they would jump when an end crosses 0, and the search would not converge.
    """
    flipped = low > 0
    low, high = np.where(flipped, -high, low), np.where(flipped, -low, high)
    even = np.where(flipped, 1 - even, even)
    bottom, top = log_ndtr(low), log_ndtr(high)
    with np.errstate(invalid="ignore"):
        log_probability = top + log1mexp(np.maximum(top - bottom, SMALLEST))
    log_share = np.minimum(np.logaddexp(bottom, log_probability + np.log(even)), 0.0)
    values = np.clip(ndtri_exp(log_share), low, high)  # rounding may exceed an end
    return np.where(flipped, -values, values), log_probability
