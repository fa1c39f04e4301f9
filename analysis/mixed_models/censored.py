"""Linear mixed models of censored values.

A censored value is known only to lie below, above or between bounds. Censoring depends on the value itself, so a model
of the known values alone would be biased.

The fit is by maximum likelihood. The variances and squared standard errors are multiplied by n / (n - 1) for n
participants. In a balanced design without covariates and censoring they then equal those of the restricted likelihood.

Tobin 1958, Econometrica 26, 24-36; with random effects Pettitt 1986, Biometrika 73, 635-643.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from scipy.special import log_ndtr, logsumexp

from tactometry.arguments.require import expect
from tactometry.errors import InvalidParameter
from tactometry.psychometric import log1mexp

from ..anova.bounded_design import BOUND, ends_of
from ..anova.design import expect_columns
from ..arrays import Array, Bools, Indices, lay_out, size_of, symmetric_inverse
from .linear import InterceptFit, MixedModel, ModelDesign, described_model, model_design

N_NODES = 31
NARROW = 1e-6
"""An interval narrower than this fraction of the values' spread counts as a value."""
LOG_ROOT_TWO_PI = 0.5 * float(np.log(2 * np.pi))
MAX_STEPS, SMALL_DECREMENT = 60, 1e-9
DIFFERENCE = 1e-4
"""Step of central differences, a compromise between truncation error (step^2) and rounding error (1 / step)."""
GRADIENT_TOLERANCE = 1e-5
MAX_RESTARTS, MAX_POLISHING = 5, 4
IMPOSSIBLE = 1e12


class Terms(NamedTuple):
    """Log-likelihoods with first and second derivatives in the mean."""

    value: Array
    by_mean: Array
    by_log_sd: Array
    curvature: Array


@dataclass(frozen=True)
class Maximum:
    """Parameters at the maximum of the log-likelihood, with their covariance.

    Parameters are the coefficients, the log residual standard deviation and the standard deviation of participants.
    `gradient` is the largest remaining derivative.
    """

    parameters: Array
    covariance: Array
    log_likelihood: float
    gradient: float


@dataclass(frozen=True)
class Intervals:
    """Intervals arranged as (participant, slot).

    Unused slots have the interval 0 to 0. A slot with equal ends is a known value.
    """

    low: Array
    high: Array
    used: Bools
    x: Array

    @classmethod
    def of(cls, ends: Array, x: Array, groups: Indices) -> "Intervals":
        narrow = ends[:, 1] - ends[:, 0] < NARROW
        ends = np.where(narrow[:, None], ends.mean(axis=1, keepdims=True), ends)
        laid, used = lay_out(groups, np.column_stack([ends, x]), np.ones(len(x)))
        return cls(laid[..., 0], laid[..., 1], used > 0, laid[..., 2:])

    @property
    def n_censored(self) -> int:
        return int((self.used & (self.low < self.high)).sum())

    def values(self, mean: Array, log_sd: Array) -> Terms:
        """Return the terms of each slot, given means (..., participant, slot)."""
        exact = of_value(self.low, mean, log_sd)
        chance = of_interval(self.low, self.high, mean, log_sd)
        merged = (np.where(self.low == self.high, *both) for both in zip(exact, chance, strict=True))
        return Terms(*(np.where(self.used, values, 0.0) for values in merged))

    def intercepts(self, parameters: Array, start: Array) -> tuple[Array, Array]:
        """Return modes and curvatures of the standardised intercepts."""
        fixed, log_sd, scale = self.x @ parameters[:-2], parameters[-2], parameters[-1]

        def at(u: Array) -> Array:
            result = self.values(fixed + scale * u[:, None], log_sd)
            value = result.value.sum(axis=1) - 0.5 * u * u
            slope = scale * result.by_mean.sum(axis=1) - u
            return np.array([value, slope, 1 - scale**2 * result.curvature.sum(axis=1)])

        u, length = start, np.ones(len(start))
        here = at(u)
        for _ in range(MAX_STEPS):
            value, slope, curvature = here
            step = length * slope / curvature
            there = at(u + step)
            better = there[0] >= value - 1e-12 * (1 + np.abs(value))
            is_near = np.abs(slope * slope / curvature) <= SMALL_DECREMENT * (1 + np.abs(value))
            u, here = np.where(better, u + step, u), np.where(better, there, here)
            length = np.where(better, 1.0, length / 4)
            if is_near.all():
                break
        return u, here[2]

    def log_likelihood(self, parameters: Array, start: Array) -> tuple[float, Array, Array]:
        """Return the log-likelihood, its gradient and the modes of the intercepts."""
        mode, curvature = self.intercepts(parameters, start)
        points, weights = np.polynomial.hermite.hermgauss(N_NODES)
        u = mode + np.sqrt(2 / curvature) * points[:, None]
        at = self.values(self.x @ parameters[:-2] + parameters[-1] * u[..., None], parameters[-2])

        # Gauss-Hermite weights include the factor exp(-x^2), which is divided out here.
        terms = at.value.sum(axis=2) - 0.5 * u * u + (points**2 + np.log(weights))[:, None]
        of_each = logsumexp(terms, axis=0)
        shares = np.exp(terms - of_each)
        by_mean, by_log_sd = (shares[..., None] * slopes for slopes in (at.by_mean, at.by_log_sd))
        by_scale = (by_mean.sum(axis=2) * u).sum()
        gradient = np.array([*np.tensordot(by_mean.sum(axis=0), self.x, axes=2), by_log_sd.sum(), by_scale])
        value = (of_each - 0.5 * np.log(np.pi * curvature)).sum()
        return float(value), gradient, mode

    def start(self) -> Array:
        """Return start values by least squares through middles or finite ends."""
        y = middle(np.stack([self.low, self.high], axis=-1))
        beta = np.linalg.lstsq(self.x[self.used], y[self.used], rcond=None)[0]
        residuals = (y - self.x @ beta)[self.used]
        sd = max(float(residuals.std()), 0.01) / np.sqrt(2)  # positive, as an exact fit has no log SD
        return np.array([*beta, np.log(sd), sd])


class _Objective:
    """Negative log-likelihood with its gradient; 1e12 on overflow."""

    def __init__(self, intervals: Intervals) -> None:
        self._intervals, self._modes = intervals, np.zeros(len(intervals.low))

    def __call__(self, parameters: Array) -> tuple[float, Array]:
        value, gradient, modes = self._intervals.log_likelihood(parameters, self._modes)
        if not (np.isfinite(value) and np.isfinite(gradient).all()):
            return IMPOSSIBLE, np.zeros(len(parameters))
        self._modes = modes
        return -value, -gradient

    def hessian(self, parameters: Array) -> Array:
        """Return the Hessian by central differences of the gradient."""
        steps = DIFFERENCE * np.maximum(1.0, np.abs(parameters))
        rows = []
        for step, unit in zip(steps, np.eye(len(parameters)), strict=True):
            (_, ahead), (_, behind) = self(parameters + step * unit), self(parameters - step * unit)
            rows.append((ahead - behind) / (2 * step))
        matrix = np.array(rows)
        return np.asarray((matrix + matrix.T) / 2)  # symmetrise, as differences are symmetric only up to their error


def maximise(intervals: Intervals) -> Maximum:
    """Maximise the likelihood by BFGS, then by Newton steps.

    BFGS starts with the inverse Hessian at the start values.
    """
    from scipy.optimize import minimize  # slow to load

    objective, parameters = _Objective(intervals), intervals.start()
    with np.errstate(all="ignore"):
        hessian = objective.hessian(parameters)
        for _ in range(MAX_RESTARTS):
            inverse = symmetric_inverse(hessian)
            # None means the identity, as scipy raises for a matrix that is not positive definite
            options: Any = {"gtol": GRADIENT_TOLERANCE, "hess_inv0": inverse if _is_definite(inverse) else None}
            parameters = minimize(objective, parameters, jac=True, method="BFGS", options=options).x
            parameters, hessian = _newton_steps(objective, parameters)
            value, gradient = objective(parameters)
            if np.abs(gradient).max() < 100 * GRADIENT_TOLERANCE:
                break
    return Maximum(parameters, symmetric_inverse(hessian), -value, float(np.abs(gradient).max()))


def _newton_steps(objective: _Objective, parameters: Array) -> tuple[Array, Array]:
    """Take Newton steps while the gradient decreases."""
    value, gradient = objective(parameters)
    for _ in range(MAX_POLISHING):
        hessian = objective.hessian(parameters)
        trial = parameters - symmetric_inverse(hessian) @ gradient
        new_value, new_gradient = objective(trial)
        is_flatter = np.abs(new_gradient).max() < 0.9 * np.abs(gradient).max()
        if not (is_flatter and new_value <= value + 1e-9):
            break
        parameters, value, gradient = trial, new_value, new_gradient
        if np.abs(gradient).max() < GRADIENT_TOLERANCE:
            break
    return parameters, hessian


def _is_definite(matrix: Array) -> bool:
    try:
        np.linalg.cholesky(matrix)
    except np.linalg.LinAlgError:
        return False
    return bool(np.isfinite(matrix).all())


def middle(ends: Array) -> Array:
    """Return the middle of an interval (..., 2), or its one finite end."""
    low, high = np.moveaxis(np.where(np.isfinite(ends), ends, ends[..., ::-1]), -1, 0)
    return np.asarray(low + (high - low) / 2)


def of_value(y: Array, mean: Array, log_sd: Array) -> Terms:
    """Return the log density of a known value."""
    inverse = np.exp(-log_sd)
    z = (np.where(np.isfinite(y), y, 0.0) - mean) * inverse
    return Terms(-0.5 * z * z - log_sd - LOG_ROOT_TWO_PI, z * inverse, z * z - 1, -(inverse**2))


def of_interval(low: Array, high: Array, mean: Array, log_sd: Array) -> Terms:
    """Return the log probability of a normal value in an interval."""
    inverse = np.exp(-log_sd)
    a, b = (low - mean) * inverse, (high - mean) * inverse
    log_chance = _log_chance(a, b)
    ratio_a, ratio_b = (np.exp(-0.5 * end * end - LOG_ROOT_TWO_PI - log_chance) for end in (a, b))
    # The density at an infinite end is 0; a finite factor prevents 0 * inf.
    a, b = (np.where(np.isfinite(end), end, 0.0) for end in (a, b))
    slope = ratio_a - ratio_b
    curvature = np.minimum(a * ratio_a - b * ratio_b - slope**2, 0.0)  # enforce log-concavity in spite of rounding
    return Terms(log_chance, slope * inverse, a * ratio_a - b * ratio_b, curvature * inverse**2)


def _log_chance(a: Array, b: Array) -> Array:
    """Return log(Phi(b) - Phi(a)), computed in the more precise tail."""
    flipped = a > 0
    low, high = np.where(flipped, -b, a), np.where(flipped, -a, b)
    upper = log_ndtr(high)
    with np.errstate(invalid="ignore"):
        difference = np.maximum(upper - log_ndtr(low), 1e-300)  # log1mexp is undefined at 0
        return np.where(high > low, upper + log1mexp(difference), 0.0)


ZERO_SD = 1e-3
WIDEST_SE = 100.0
"""Largest standard error of a coefficient, in SDs of the values; above it the likelihood has no finite maximum."""
LARGEST_STEP = 0.02
"""Largest step that the remaining gradient may suggest, in standard errors."""
ZERO = 1e-7


def censored_model(
    table: pd.DataFrame,
    *,
    dependent: str,
    low: str,
    high: str,
    factors: Sequence[str] = (),
    covariates: Sequence[str] = (),
    subject: str,
    interactions: bool = True,
    interval: float = 0.95,
) -> MixedModel:
    """Fit a mixed model with random intercepts to values that may be censored.

    - `dependent`: Column of the values; missing if a value is censored.
    - `low`, `high`: Columns of the bounds, used if the value is missing. A missing bound is infinite.
    - `factors`, `covariates`, `subject`, `interactions`, `interval`: As for `mixed_model`.

    Raises
    ------
    InvalidParameter
        As `mixed_model`. Also for a row without value and bounds, a lower bound above the upper bound, or a likelihood
        without a finite maximum (for example if all values of a condition are below a bound).

    >>> values = [3.0, 4, 6, 2, 5, 6, 4, 4, None, 1, 3, 5]
    >>> table = pd.DataFrame({"who": list("aaabbbcccddd"), "force_n": [0.5, 1, 2] * 4, "y": values})
    >>> result = censored_model(table.assign(low=6.5, high=None), dependent="y", low="low", high="high",
    ...     factors=["force_n"], subject="who")
    >>> result.n_censored, result.coefficients["estimate"].round(2).tolist()
    (1, [2.5, 1.5, 3.52])
    """
    expect_columns(table, [dependent, low, high], "censored_model")
    ends = ends_of(table, dependent, low, high)
    is_empty = np.isinf(ends).all(axis=1)
    expect(not is_empty.any(), f"{dependent}, row {is_empty.argmax()}", "neither a value nor a bound", BOUND)
    middles = table.assign(**{dependent: middle(ends)})
    design = model_design(middles, dependent, factors, covariates, subject, interactions=interactions, base={})
    size = size_of(design.y)
    y = design.y / size
    centre, scale = float(y.mean()), float(y.std()) or 1.0
    units = (ends / size - centre) / scale
    _refuse_unheld(units, design)
    intervals = Intervals.of(units, design.x, design.groups)
    maximum = maximise(intervals)
    _refuse_endless(maximum, design)
    n_known = len(y) - intervals.n_censored  # densities have the unit 1 / y, probabilities have no unit
    log_likelihood = maximum.log_likelihood - n_known * float(np.log(scale * size))
    fit = _intercept_fit(maximum, design, log_likelihood)
    return described_model(design, fit, (centre * size, scale * size), interval, intervals.n_censored)


def _refuse_unheld(ends: Array, matrix: ModelDesign) -> None:
    """Raise for data without a finite maximum, before a long search."""
    if np.all(ends[:, 0] == ends[:, 1]):
        return
    endless = endless_direction(ends, matrix.x)
    if endless is not None:
        steepest = int(np.argmax(np.abs(endless)))
        raise _endless(matrix.names[steepest])
    found = "known values that terms and participants explain exactly"
    has_error = not leaves_no_error(ends, matrix.x, matrix.groups)
    expect(has_error, "censored_model", found, "more known values, or fewer terms")


def _endless(name: str) -> InvalidParameter:
    return InvalidParameter(
        f"{name}: found a likelihood without a finite maximum, expected known values that determine each "
        "coefficient; remove conditions in which all values are censored"
    )


def _refuse_endless(maximum: Maximum, matrix: ModelDesign) -> None:
    errors = np.sqrt(np.diagonal(maximum.covariance)[: len(matrix.names)])
    worst = int(np.argmax(errors))
    if not (np.isfinite(maximum.log_likelihood) and errors[worst] <= WIDEST_SE):
        raise _endless(matrix.names[worst])
    found = f"a likelihood that still rises (gradient {maximum.gradient:.2g})"
    expected = "a maximum, which needs more known values for these terms"
    expect(maximum.gradient * errors[worst] <= LARGEST_STEP, "censored_model", found, expected)


def _intercept_fit(maximum: Maximum, design: ModelDesign, log_likelihood: float) -> InterceptFit:
    p, n_participants = len(design.names), design.n_participants
    inflation = n_participants / (n_participants - 1)
    residual = float(np.exp(maximum.parameters[p]))
    participant = abs(float(maximum.parameters[p + 1]))  # the sign is arbitrary, as u and -u are equally likely
    sds = 0.0 if participant < ZERO_SD * residual else participant, residual
    covariance = maximum.covariance[:p, :p] * inflation
    return InterceptFit(maximum.parameters[:p], covariance, *sds, log_likelihood, inflation)


def endless_direction(ends: Array, x: Array) -> Array | None:
    """Return a direction of coefficients in which the likelihood never falls.

    In this direction, known values do not change and every bound in `ends` (row, 2) is satisfied better. Without such a
    direction the likelihood has a finite maximum at any variance (separation, Albert and Anderson 1984, Biometrika 71,
    1-10).

    >>> endless_direction(np.array([[1.0, 1.0], [2.0, 2.0], [3.0, np.inf]]), np.array([[1.0, 0], [1, 0], [1, 1]]))
    array([0., 1.])
    """
    from scipy.optimize import linprog  # slow to load

    upward, downward = np.isposinf(ends[:, 1]), np.isneginf(ends[:, 0])
    one_sided = np.concatenate([x[upward & ~downward], -x[downward & ~upward]])
    if not len(one_sided):
        return None
    fixed = x[~upward & ~downward]
    kept, still = np.zeros(len(one_sided)), np.zeros(len(fixed))
    # The length is arbitrary; limits of 1 keep the linear programme finite.
    best = linprog(-one_sided.sum(axis=0), A_ub=-one_sided, b_ub=kept, A_eq=fixed, b_eq=still, bounds=(-1, 1))
    if best.fun is None or best.fun >= -ZERO:
        return None
    return np.asarray(best.x, dtype=np.float64) + 0.0  # avoid -0


def leaves_no_error(ends: Array, x: Array, groups: Indices) -> bool:
    """Return True if the model fits several values of a participant exactly."""
    known = ends[:, 0] == ends[:, 1]
    participants = np.unique(groups[known])
    if known.sum() <= len(participants):
        return False  # with one value per participant, the variance between participants keeps the density finite
    y = ends[known, 0]
    intercepts = np.equal.outer(groups[known], participants).astype(np.float64)
    every = np.concatenate([x[known], intercepts], axis=1)
    residual = y - every @ np.linalg.lstsq(every, y, rcond=None)[0]
    return bool(np.abs(residual).max() <= ZERO * np.abs(y).max())
