"""Logistic regression: the odds of one of two answers, with errors of answers that are alone or go together."""

from typing import Any

import numpy as np
from scipy.special import expit, log_expit

from ..arrays import Array, Bools, Indices

GRADIENT = 1e-9
"""Of the mean log likelihood, at which the search ends; a last step of Newton's squares what is left."""
MOST_LOG_ODDS = 16.0
"""Beyond these the predictors part the answers: the likelihood has no maximum, or one that as many trials would have to
show as nobody asks for (odds of 9e6)."""


def logistic_fit(design: Array, answers: Bools, groups: Indices | None = None) -> tuple[Array, Array] | None:
    """Coefficients of the log odds and their covariance, by maximum likelihood; None where the odds have no end.

    Parameters
    ----------
    design : (n_trials, n) array
        Predictors, whose columns are independent.
    answers : (n_trials,) array of bool
        Which answers are those whose odds are told.
    groups : (n_trials,) array of int, optional
        Answers of a group go together: the covariance is Liang and Zeger's sandwich (1986, Biometrika 73, 13-22, eq. 7)
        for a few groups, times g / (g - 1) (n - 1) / (n - k).

    Examples
    --------
    >>> beta, covariance = logistic_fit(np.ones((4, 1)), np.array([True, True, True, False]))
    >>> beta.round(3).tolist(), covariance.round(3).tolist()
    ([1.099], [[1.333]])
    """
    from scipy.optimize import minimize  # slow to load

    sides = np.where(answers, 1.0, -1.0)[:, None] * design

    def loss(beta: Array) -> tuple[float, Array]:
        return -float(log_expit(sides @ beta).mean()), slopes(beta).mean(axis=0)

    def slopes(beta: Array) -> Array:
        return -sides * expit(-sides @ beta)[:, None]

    def curvature(beta: Array) -> Array:
        p = expit(sides @ beta)
        return np.asarray((sides * (p * (1 - p))[:, None]).T @ sides / len(sides), dtype=np.float64)

    start = np.zeros(design.shape[1])
    options: Any = {"gtol": GRADIENT}
    found: Array = minimize(loss, start, jac=True, hess=curvature, method="trust-exact", options=options).x
    if np.abs(design @ found).max() > MOST_LOG_ODDS:
        return None
    found = found - np.linalg.solve(curvature(found), slopes(found).mean(axis=0))
    inverse: Array = np.linalg.inv(curvature(found) * len(sides)).astype(np.float64)
    return found, inverse if groups is None else _sandwich(inverse, slopes(found), groups)


def _sandwich(inverse: Array, slopes: Array, groups: Indices) -> Array:
    n_trials, n = slopes.shape
    n_groups = int(groups.max()) + 1
    sums = np.zeros((n_groups, n))
    np.add.at(sums, groups, slopes)
    few = n_groups / (n_groups - 1) * (n_trials - 1) / (n_trials - n)
    return np.asarray(few * inverse @ (sums.T @ sums) @ inverse)
