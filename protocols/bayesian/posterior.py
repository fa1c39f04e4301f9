"""Weights of a grid of parameters: log space throughout, so that no cell is lost that may come back."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from tactometry.arguments.require import expect, numbers, of_kind, one_of

from ..procedures.procedure import Ending
from .outcome_model import Array

HIGHEST = 1 + 1e-9
"""How much the weight of an end must pass all others to count as the highest."""

LOWEST = -1e300
"""For log 0 in a product with 0."""


@dataclass(frozen=True, eq=False)
class Posterior:
    """Normalised weights (n_cells,) and their logarithms."""

    log_weights: Array
    weights: Array

    @classmethod
    def of(cls, log_weights: Array) -> Self | None:
        """Normalised; None if every weight is zero.

        >>> Posterior.of(np.array([-2000.0, -2000.0])).weights
        array([0.5, 0.5])
        """
        highest = float(log_weights.max())
        if not math.isfinite(highest):
            return None
        shifted = log_weights - highest  # the largest weight is 1 before they are divided: none overflows
        weights = np.exp(shifted)
        total = float(weights.sum())
        shifted -= math.log(total)
        weights /= total
        return cls(shifted, weights)

    @property
    def entropy(self) -> float:
        """Nat; a weight of zero adds nothing."""
        return -float(self.weights @ np.maximum(self.log_weights, LOWEST))

    def after(self, log_likelihood: Array) -> Self | None:
        """After an answer with these log likelihoods, (n_cells,); None if no cell allows it."""
        return type(self).of(self.log_weights + log_likelihood)


def log_prior(parameters: Mapping[str, tuple[float, ...]], prior: Mapping[str, Sequence[float]], where: str) -> Array:
    """The sum of the parameters' log priors, (n_cells,); a parameter without one is flat.

    Raises
    ------
    InvalidParameter
        If a prior is of no parameter, of another length, or not of finite numbers from 0 with one above it.
    """
    of_kind(where, Mapping, prior=prior)
    for name, weights in prior.items():
        numbers(f"{where}.prior[{name!r}]", weights)
        one_of(f"{where}.prior", name, parameters)
        given = np.asarray(weights, dtype=np.float64)
        n_values = len(parameters[name])
        are_weights = given.shape == (n_values,) and (given >= 0).all() and 0 < given.sum() < math.inf
        listed = f"{len(weights)} weights from {given.min(initial=0):g} on"
        expect(are_weights, f"{where}.prior[{name!r}]", listed, f"{n_values} finite numbers from 0, not all 0")
    with np.errstate(divide="ignore"):
        axes = [np.log(prior.get(name, np.ones(len(values)))) for name, values in parameters.items()]
    total: Array = sum(np.ix_(*axes), start=np.zeros(()))
    return np.asarray(total.ravel(), dtype=np.float64)


def edge(values: Array, marginal: Array) -> Ending | None:
    """Whether the highest weight is that of the greatest or the least value, which then say only a bound.

    >>> edge(np.array([1.0, 2.0, 3.0]), np.array([0.6, 0.3, 0.1]))
    'censored_below'
    """
    if len(values) < 2:
        return None
    ends: tuple[tuple[Ending, int], ...] = (
        ("censored_above", int(values.argmax())),
        ("censored_below", int(values.argmin())),
    )
    for ending, at in ends:
        if marginal[at] > HIGHEST * float(np.delete(marginal, at).max()):
            return ending
    return None


def mean_sd(values: Array, marginal: Array) -> tuple[float, float]:
    """Mean and standard deviation of a parameter with these weights.

    >>> mean_sd(np.array([1.0, 3.0]), np.array([0.5, 0.5]))
    (2.0, 1.0)
    """
    mean = float(marginal @ values)
    return mean, math.sqrt(float(marginal @ (values - mean) ** 2))
