"""Linear mixed models of values of which some are known to lie below, above or between bounds only.

A known value contributes its density, a censored one the chance of its interval (Tobin 1958, Econometrica 26, 24-36;
with random effects Pettitt 1986, Biometrika 73, 635-643). The random intercept is integrated over by adaptive
Gauss-Hermite quadrature, from Laplace's approximation, which is exact where nothing is censored.

Whether values and bounds hold every coefficient of a linear model, or the likelihood rises without end along one.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.special import log_ndtr

from tactometry.arguments.require import expect
from tactometry.errors import InvalidParameter
from tactometry.psychometric import log1mexp

from ..anova.bounded_design import BOUND, ends_of
from ..anova.design import expect_columns
from ..arrays import Array, Bools, Expansion, Indices, lay_out, size_of
from .laplace import ClusteredModel as Clusters, MixedFit, maximise, maximise_by_quadrature
from .linear import InterceptFit, MixedModel, ModelDesign, described_model, model_design

N_NODES = 31
NARROW = 1e-6
"""An interval narrower than this part of the values' spread is a value."""
ZERO_SD = 1e-3
WIDEST_SE = 100.0
"""A coefficient of a larger standard error, in standard deviations of the values, has no finite maximum."""
LARGEST_STEP = 0.02
"""In standard errors: what the gradient that is left may still ask for."""
LOG_ROOT_TWO_PI = 0.5 * float(np.log(2 * np.pi))
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
    """A linear mixed model with a random intercept per participant, of values that may be censored.

    Parameters
    ----------
    dependent : str
        Its column; missing where the value is censored.
    low, high : str
        Columns of bounds, read where the value is missing; a missing bound is infinite.
    factors, covariates, subject, interactions, interval
        As for `mixed_model`.

    Raises
    ------
    InvalidParameter
        As `mixed_model`; for a row without value and bounds or with crossed ones, and where no finite coefficients
        explain the censored values best (as if all values of a condition lie below).

    Notes
    -----
    Maximum likelihood; the variances and squared standard errors are multiplied by n / (n - 1) for n participants,
    which makes them those of the restricted likelihood in a balanced design without covariates where nothing is
    censored. Censoring may depend on the value itself, which a model of the known values alone does not allow.

    >>> values = [3.0, 4, 6, 2, 5, 6, 4, 4, None, 1, 3, 5]
    >>> table = pd.DataFrame({"who": list("aaabbbcccddd"), "force_n": [0.5, 1, 2] * 4, "y": values})
    >>> found = censored_model(table.assign(low=6.5, high=None), dependent="y", low="low", high="high",
    ...     factors=["force_n"], subject="who")
    >>> found.n_censored, found.coefficients["estimate"].round(2).tolist()
    (1, [2.5, 1.5, 3.52])
    """
    expect_columns(table, [dependent, low, high], "censored_model")
    ends = ends_of(table, dependent, low, high)
    is_empty = np.isinf(ends).all(axis=1)
    expect(not is_empty.any(), f"{dependent}, row {is_empty.argmax()}", "the bounds -inf and inf", BOUND)
    middles = table.assign(**{dependent: _middle(ends)})
    design = model_design(middles, dependent, factors, covariates, subject, interactions=interactions, base={})
    size = size_of(design.y)
    y = design.y / size
    centre, scale = float(y.mean()), float(y.std()) or 1.0
    units = (ends / size - centre) / scale
    _refuse_unheld(units, design)
    model = _Censored.of(units, design.x, design.groups)
    mixed_fit = model.fit()
    _refuse_endless(mixed_fit, design)
    n_known = len(y) - model.n_censored  # a density has the unit 1 / y, the chance of an interval has none
    log_likelihood = mixed_fit.log_marginal - n_known * float(np.log(scale * size))
    fit = _intercept_fit(mixed_fit, design, log_likelihood)
    return described_model(design, fit, (centre * size, scale * size), interval, model.n_censored)


def _middle(ends: Array) -> Array:
    """Of an interval, or its one end."""
    low, high = np.where(np.isfinite(ends), ends, ends[:, ::-1]).T
    return np.asarray(low + (high - low) / 2)


@dataclass(frozen=True)
class _Censored:
    """Intervals laid out as (participant, slot), 0 to 0 where a slot is not `used`; a value where both ends meet."""

    low: Array
    high: Array
    used: Bools
    x: Array

    @classmethod
    def of(cls, ends: Array, x: Array, groups: Indices) -> "_Censored":
        narrow = ends[:, 1] - ends[:, 0] < NARROW
        ends = np.where(narrow[:, None], ends.mean(axis=1, keepdims=True), ends)
        laid, used = lay_out(groups, np.column_stack([ends, x]), np.ones(len(x)))
        return cls(laid[..., 0], laid[..., 1], used > 0, laid[..., 2:])

    @property
    def n_censored(self) -> int:
        return int((self.used & (self.low < self.high)).sum())

    def fit(self) -> MixedFit:
        fixed = self.x[:, :, None, :]
        random = np.where(self.used, 1.0, 0.0)[:, :, None, None]
        clusters = Clusters(self.log_likelihood, fixed, random, np.ones((1, 1, 1)), n_shared=1)
        by_laplace = maximise(clusters, self._start())
        return maximise_by_quadrature(clusters, by_laplace, N_NODES) if self.n_censored else by_laplace

    def _start(self) -> Array:
        """Least squares through the middles or bounds; half of the residual variance to each side."""
        ends = np.stack([self.low.ravel(), self.high.ravel()], axis=1)
        y = _middle(ends).reshape(self.low.shape)
        beta = np.linalg.lstsq(self.x[self.used], y[self.used], rcond=None)[0]
        residuals = (y - self.x @ beta)[self.used]
        sd = max(float(residuals.std()), 0.01) / np.sqrt(2)  # of an exact fit it would be 0, which has no logarithm
        return np.concatenate([beta, [np.log(sd), sd]])

    def log_likelihood(self, points: Array) -> Expansion:
        """At points (..., 2) of mean and log standard deviation."""
        eta, log_sd = points[..., 0], points[..., 1]
        of_intervals = _interval(self.low, self.high, eta, log_sd)
        of_values = _value(self.low, eta, log_sd)
        is_known = self.low == self.high
        pairs = zip(vars(of_values).values(), vars(of_intervals).values(), strict=True)
        merged = [np.where(_like(is_known, exact), exact, chance) for exact, chance in pairs]
        return Expansion(*(values * _like(self.used, values) for values in merged))


def _like(mask: Bools, values: Array) -> Bools:
    """The mask with as many axes as the values."""
    return mask.reshape(mask.shape + (1,) * (values.ndim - mask.ndim))


def _value(y: Array, eta: Array, log_sd: Array) -> Expansion:
    """Log density of a known value."""
    y = np.where(np.isfinite(y), y, 0.0)
    inverse = np.exp(-log_sd)
    z = (y - eta) * inverse
    log_density = -0.5 * z * z - log_sd - LOG_ROOT_TWO_PI
    gradient = np.stack([z * inverse, z * z - 1], axis=-1)
    hessian = _square(-(inverse**2), -2 * z * inverse, -2 * z * z)
    return Expansion(log_density, gradient, hessian)


def _interval(low: Array, high: Array, eta: Array, log_sd: Array) -> Expansion:
    """Log chance of a normal value between two ends, of which one may be infinite."""
    inverse = np.exp(-log_sd)
    a, b = (low - eta) * inverse, (high - eta) * inverse
    log_chance = _log_chance(a, b)
    ratio_a, ratio_b = (np.exp(-0.5 * end * end - LOG_ROOT_TWO_PI - log_chance) for end in (a, b))
    # At an infinite end the density is 0: the end's place must not make NaN of its product with it.
    a, b = (np.where(np.isfinite(end), end, 0.0) for end in (a, b))
    by_a, by_b = -ratio_a, ratio_b
    aa = a * ratio_a - ratio_a**2
    ab = ratio_a * ratio_b
    bb = -b * ratio_b - ratio_b**2
    by_eta, by_log_sd = -(by_a + by_b) * inverse, -(a * by_a + b * by_b)
    gradient = np.stack([by_eta, by_log_sd], axis=-1)
    curved = np.minimum(aa + 2 * ab + bb, 0.0) * inverse**2  # log-concave, also where all digits are lost
    mixed = (by_a + by_b + a * aa + (a + b) * ab + b * bb) * inverse
    by_log_sd_twice = a * by_a + b * by_b + a * a * aa + 2 * a * b * ab + b * b * bb
    return Expansion(log_chance, gradient, _square(curved, mixed, by_log_sd_twice))


def _square(first: Array, mixed: Array, second: Array) -> Array:
    rows = [np.stack([first, mixed], axis=-1), np.stack([mixed, second], axis=-1)]
    return np.stack(rows, axis=-2)


def _log_chance(a: Array, b: Array) -> Array:
    """log(Phi(b) - Phi(a)), in the tail that keeps its digits; of an empty interval 0."""
    flipped = a > 0
    low, high = np.where(flipped, -b, a), np.where(flipped, -a, b)
    upper = log_ndtr(high)
    with np.errstate(invalid="ignore"):
        difference = np.maximum(upper - log_ndtr(low), 1e-300)  # log1mexp has no value at 0
        return np.where(high > low, upper + log1mexp(difference), 0.0)


def _refuse_unheld(ends: Array, matrix: ModelDesign) -> None:
    """Before a search that would go on for long."""
    if np.all(ends[:, 0] == ends[:, 1]):
        return
    endless = endless_direction(ends, matrix.x)
    if endless is not None:
        steepest = int(np.argmax(np.abs(endless)))
        raise _endless(matrix.names[steepest])
    found = "known values that the terms and participants explain without error"
    has_error = not leaves_no_error(ends, matrix.x, matrix.groups)
    expect(has_error, "censored_model", found, "more known values, or fewer terms")


def _endless(name: str) -> InvalidParameter:
    return InvalidParameter(
        f"{name}: found that the likelihood has no finite maximum, expected known values that hold each coefficient; "
        "leave the condition out in which all values are censored"
    )


def _refuse_endless(mixed_fit: MixedFit, matrix: ModelDesign) -> None:
    errors = np.sqrt(np.diagonal(mixed_fit.covariance)[: len(matrix.names)])
    worst = int(np.argmax(errors))
    if not (np.isfinite(mixed_fit.log_marginal) and errors[worst] <= WIDEST_SE):
        raise _endless(matrix.names[worst])
    found = f"that the likelihood still rises (by {mixed_fit.gradient:.2g} along a parameter)"
    expected = "a maximum; too few values are known for these terms"
    expect(mixed_fit.gradient * errors[worst] <= LARGEST_STEP, "censored_model", found, expected)


def _intercept_fit(mixed_fit: MixedFit, design: ModelDesign, log_likelihood: float) -> InterceptFit:
    p, n_participants = len(design.names), design.n_participants
    inflation = n_participants / (n_participants - 1)
    residual = float(np.exp(mixed_fit.parameters[p]))
    participant = abs(float(mixed_fit.parameters[p + 1]))  # a scale may end on either side of 0: u is as likely as -u
    sds = 0.0 if participant < ZERO_SD * residual else participant, residual
    covariance = mixed_fit.covariance[:p, :p] * inflation
    return InterceptFit(mixed_fit.parameters[:p], covariance, *sds, log_likelihood, inflation)


def endless_direction(ends: Array, x: Array) -> Array | None:
    """Coefficients (column,) along which no known value moves and every bound (row, 2) is kept ever better; None if
    there are none, and the likelihood has a finite maximum at any variance.

    It is the separation of Albert and Anderson (1984, Biometrika 71, 1-10), found by a linear programme.

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
    y = ends[known, 0]
    intercepts = np.equal.outer(groups[known], participants).astype(np.float64)
    every = np.concatenate([x[known], intercepts], axis=1)
    residual = y - every @ np.linalg.lstsq(every, y, rcond=None)[0]
    return bool(np.abs(residual).max() <= ZERO * np.abs(y).max())
