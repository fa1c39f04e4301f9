"""Linear mixed models of censored values.

A censored value is known only to lie below, above or between bounds. Censoring depends on the value itself, so a model
of the known values alone would be biased.

The fit is by maximum likelihood. The variances and squared standard errors are multiplied by n / (n - 1) for n
participants. In a balanced design without covariates and censoring they then equal those of the restricted likelihood.

Tobin 1958, Econometrica 26, 24-36; with random effects Pettitt 1986, Biometrika 73, 635-643.
"""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from tactometry.arguments.require import expect
from tactometry.errors import InvalidParameter

from ..anova.bounded_design import BOUND, ends_of
from ..anova.design import expect_columns
from ..arrays import Array, Indices, size_of
from .censored_likelihood import Intervals, Maximum, maximise, middle
from .linear import InterceptFit, MixedModel, ModelDesign, described_model, model_design

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
    >>> found = censored_model(table.assign(low=6.5, high=None), dependent="y", low="low", high="high",
    ...     factors=["force_n"], subject="who")
    >>> found.n_censored, found.coefficients["estimate"].round(2).tolist()
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
