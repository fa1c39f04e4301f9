"""The normal model under an analysis of variance, fitted by maximum likelihood to values of which some are bounds.

A participant's values have the means of their conditions and the covariance that the analysis of variance supposes: one
variance per stratum (participants; participants by each factor; by each interaction). Where all values are known this
is the analysis of variance itself, F and degrees of freedom to the last digits; a value that is known by a bound, or
not at all, counts as what is known (Tobin 1958, Econometrica 26, 24-36). Fitted by expectation and maximisation
(Dempster, Laird and Rubin 1977), with the observed information of Louis (1982, Journal of the Royal Statistical Society
B 44, 226-233).

Normal values that are known to lie between ends only: their chance, and weighted points of what they may be.

One value after the other is drawn between its ends given those before it (the simulator of Geweke, Hajivassiliou and
Keane; Genz and Bretz 2009, Computation of Multivariate Normal and t Probabilities, section 4.1), at points that fill
the cube evenly and are always the same. The chance of one value is exact, that of two right to five digits, a mean to a
few thousandths of its standard deviation.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from scipy.special import log_ndtr, ndtri_exp

from tactometry.psychometric import log1mexp

from ..arrays import Array, Bools, Indices
from .contrasts import contrasts, effect_places

TOLERANCE = 1e-8
"""Of a step, in standard deviations of the values and in logarithms of the variances."""
MAX_STEPS = 2000
LEAST_VARIANCE = 1e-12
"""Of the largest: below, a stratum has no error."""
LOG_TWO_PI = float(np.log(2 * np.pi))
N_POINTS = 1024
"""A power of two, for which the sequence of Sobol is even."""
SEED = 20_171_101
"""Of its scrambling, so that the same data give the same numbers."""
SMALLEST = 1e-300


@dataclass(frozen=True)
class BoundedValues:
    """Values of shape (participant, cell), each between `low` and `high`: known where they are equal, missing where
    both are infinite. `group` (participant,) counts from 0; `n_levels` are those of the factors, the last one fastest.
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
        """Participants of each group."""
        return np.bincount(self.group).astype(np.float64)

    @cached_property
    def strata(self) -> tuple[Array, ...]:
        """Orthonormal contrasts (contrast, cell) of each stratum, participants first."""
        of_strata = [(), *effect_places(len(self.n_levels))]
        return tuple(contrasts(self.n_levels, places) for places in of_strata)

    def matrix(self, variances: Array) -> Array:
        """The covariance (cell, cell) with these variances of the strata; its inverse with their reciprocals."""
        pairs = zip(variances, self.strata, strict=True)
        return np.asarray(sum(variance * stratum.T @ stratum for variance, stratum in pairs), dtype=np.float64)


@dataclass(frozen=True)
class Points:
    """What the values (n, cell) of one participant may be, with weights (n,) that sum to 1, one point if all are known;
    `log_chance` of what is known of them."""

    values: Array
    weights: Array
    log_chance: float = 0.0

    def mean(self) -> Array:
        return np.asarray(self.weights @ self.values)


@dataclass(frozen=True)
class StrataFit:
    """`means` (group, cell) and `variances` (stratum,) of the largest likelihood; `covariance` of the means, row by
    row, and then the logarithms of the variances, 0 of one without error; `moments` (group, cell, cell), the covariance
    of each group's values with n - 1 degrees of freedom, as far as they are known."""

    data: BoundedValues
    means: Array
    variances: Array
    covariance: Array
    moments: Array
    log_likelihood: float
    converged: bool

    @property
    def model(self) -> Array:
        """The covariance (cell, cell) of a participant's values."""
        return self.data.matrix(self.variances)

    @property
    def pooled(self) -> Array:
        """The covariance (cell, cell) of the values within groups."""
        return np.asarray(np.tensordot(self.data.sizes - 1, self.moments, axes=1) / self.df)

    @property
    def of_means(self) -> Array:
        """The covariance of the means (group * cell), row by row."""
        n = self.means.size
        return self.covariance[:n, :n]

    @property
    def df(self) -> int:
        """Of the participants within groups."""
        return len(self.data.low) - len(self.means)

    @property
    def inflation(self) -> float:
        """From the likelihood's variances to the restricted likelihood's."""
        return len(self.data.low) / self.df

    @property
    def has_error(self) -> Bools:
        """Of each stratum: its variance is more than rounding leaves of none."""
        return _above_rounding(self.variances)

    def df_of(self, stratum: int) -> float:
        """Degrees of freedom of each contrast of a stratum: `df`, less what bounds leave open about its variance
        (Satterthwaite: twice the square of a variance over the variance of its estimate)."""
        if not self.has_error[stratum]:
            return float(self.df)
        place = self.means.size + stratum
        # The covariance is that of the logarithm of the variance, so that its square is divided out already.
        df = 2 / float(self.covariance[place, place]) / len(self.data.strata[stratum])
        return min(df / self.inflation, float(self.df))


def fit_strata(data: BoundedValues) -> StrataFit:
    """The fit of values of about unit size.

    Raises
    ------
    numpy.linalg.LinAlgError
        If the search leaves the floats.
    """
    means, variances = _start(data)
    for _ in range(MAX_STEPS):
        step = _maximisation(data, _points(data, means, variances))
        change = _change(step, (means, variances))
        means, variances = step
        if change < TOLERANCE:
            break
    points = _points(data, means, variances)
    second = _second_moments(data, points, means)
    moments = second / np.maximum(data.sizes - 1, 1)[:, None, None]
    covariance = _inverse_of_free(_information(data, points, means, variances), variances)
    log_likelihood = float(sum(of_one.log_chance for of_one in points))
    return StrataFit(data, means, variances, covariance, moments, log_likelihood, change < TOLERANCE)


def _change(new: tuple[Array, Array], old: tuple[Array, Array]) -> float:
    (means, variances), (old_means, old_variances) = new, old
    of_means = float(np.abs(means - old_means).max() / np.sqrt(variances.max()))
    of_variances = float(np.abs(np.log(variances / old_variances)).max())
    return max(of_means, of_variances)


def _start(data: BoundedValues) -> tuple[Array, Array]:
    """From the known values and, in place of the others, their bounds or the mean of the cell."""
    ends = np.where(np.isfinite(data.low), data.low, data.high)
    known = np.where(data.known, data.low, np.nan)
    held = np.where(np.isfinite(ends), ends, np.nanmean(known, axis=0))
    return _maximisation(data, [Points(row[None], np.ones(1)) for row in held])


def _maximisation(data: BoundedValues, points: Sequence[Points]) -> tuple[Array, Array]:
    """Means and variances of the completed values."""
    expected = np.stack([of_one.mean() for of_one in points])
    members = np.equal.outer(np.arange(len(data.sizes)), data.group)
    means = members @ expected / data.sizes[:, None]
    second = _second_moments(data, points, means).sum(axis=0) / len(expected)
    # The mean variance of a stratum's contrasts: the trace of C M C', over their number.
    variances = np.array([np.sum((stratum @ second) * stratum) / len(stratum) for stratum in data.strata])
    return means, np.maximum(variances, LEAST_VARIANCE * variances.max())


def _second_moments(data: BoundedValues, points: Sequence[Points], means: Array) -> Array:
    """Sums over the participants of each group (group, cell, cell) of squares and products about the means."""
    sums = np.zeros((len(means), *[means.shape[1]] * 2))
    for of_one, place in zip(points, data.group, strict=True):
        away = of_one.values - means[place]
        sums[place] += (away * of_one.weights[:, None]).T @ away
    return sums


def _points(data: BoundedValues, means: Array, variances: Array) -> list[Points]:
    """Of each participant, given what is known."""
    covariance = data.matrix(variances)
    rows = zip(data.low, data.high, means[data.group], strict=True)
    return [_points_of_one(low, high, mean, covariance) for low, high, mean in rows]


def _points_of_one(low: Array, high: Array, mean: Array, covariance: Array) -> Points:
    """The density of the known values, then the others given them."""
    known = low == high
    of_known = covariance[np.ix_(known, known)]
    both = covariance[np.ix_(known, ~known)]
    away = low[known] - mean[known]
    onto = np.linalg.solve(of_known, both).T  # regression of the others on the known values
    square = float(away @ np.linalg.solve(of_known, away))
    log_determinant = float(np.linalg.slogdet(of_known)[1])
    log_density = -0.5 * (log_determinant + square + len(of_known) * LOG_TWO_PI)
    if known.all():
        return Points(low[None], np.ones(1), log_density)
    spread = np.asarray(covariance[np.ix_(~known, ~known)] - onto @ both, dtype=np.float64)
    conditional_mean = mean[~known] + onto @ away
    others = truncated_normal(conditional_mean, spread, low[~known], high[~known])
    values = np.empty((len(others.weights), len(low)))
    values[:, known], values[:, ~known] = low[known], others.values
    return Points(values, others.weights, log_density + others.log_chance)


def _above_rounding(variances: Array) -> Bools:
    return np.asarray(variances > LEAST_VARIANCE * variances.max())


def _inverse_of_free(information: Array, variances: Array) -> Array:
    """The covariance of what was estimated. A variance without error is no estimate but the end of its range, where the
    logarithm has no information but rounding, of either sign: it is held, with a covariance of 0."""
    free = np.concatenate([np.full(len(information) - len(variances), True), _above_rounding(variances)])
    covariance = np.zeros(information.shape)
    covariance[np.ix_(free, free)] = np.linalg.inv(information[np.ix_(free, free)])
    return covariance


def _information(data: BoundedValues, points: Sequence[Points], means: Array, variances: Array) -> Array:
    """The negative Hessian of the log-likelihood along means and log variances: that of completed values, less the
    variance of their gradient where they are not known."""
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
    pairs = zip(data.strata, variances, strict=True)
    by_stratum = [away @ stratum.T @ stratum / variance for stratum, variance in pairs]
    halves = np.stack([0.5 * np.sum(pull * away, axis=1) for pull in by_stratum], axis=1)
    # Louis: the gradient's variance over what the values may be is information that is missing.
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
    """Of normal values of `mean` (d,) and `covariance` (d, d), between `low` and `high` (d,), which may be infinite.

    >>> found = truncated_normal(np.zeros(1), np.eye(1), np.array([-np.inf]), np.zeros(1))
    >>> round(float(np.exp(found.log_chance)), 9), round(float(found.mean()[0]), 2)
    (0.5, -0.8)
    """
    root, even = np.linalg.cholesky(covariance), _even(len(mean))
    steps, log_weights = np.zeros(even.shape), np.zeros(len(even))
    for j, sd in enumerate(np.diagonal(root)):
        middle = mean[j] + steps[:, :j] @ root[j, :j]
        bottom, top = (low[j] - middle) / sd, (high[j] - middle) / sd
        steps[:, j], log_chance = _one(even[:, j], bottom, top)
        log_weights += log_chance
    largest = log_weights.max()
    weights = np.exp(log_weights - largest)  # a chance far out in a tail is below the floats
    log_mean = largest + np.log(weights.mean())
    return Points(mean + steps @ root.T, weights / weights.sum(), float(log_mean))


@cache
def _even(n_dimensions: int) -> Array:
    from scipy.stats import qmc  # slow to load

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
    log_share = np.logaddexp(bottom, log_chance + np.log(even))
    log_share = np.minimum(log_share, 0.0)  # rounding may lead above a share of 1
    values = np.clip(ndtri_exp(log_share), low, high)  # rounding may lead beyond an end
    return np.where(flipped, -values, values), log_chance
