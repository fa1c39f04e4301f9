"""Models of answers for Bayesian procedures."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Protocol, runtime_checkable

import numpy as np
from annotated_types import Ge
from numpy.typing import NDArray

from tactometry.arguments.constraints import constrained
from tactometry.arguments.require import expect, numbers, of_kind, some

Array = NDArray[np.float64]


class Likelihoods(Protocol):
    """Probabilities of outcomes at levels, for products with weights.

    `DenseLikelihoods` also accepts stacks of weights (n_cells, n_sets). The sets are then the last axis of its
    results.
    """

    def total(self, weights: Array) -> Array:
        """Sum probability times weight over cells, (n_outcomes, n_levels)."""

    def joint(self, weights: Array) -> Array:
        """Sum over all parameters but the first, (n_outcomes, n_levels, n_first)."""

    def certainty(self, weights: Array) -> Array:
        """Sum weight times p log p over cells and outcomes, (n_levels,)."""

    def log_likelihood(self, index: int, outcome: int) -> Array | None:
        """Return log P(outcome) at a candidate, (n_cells,), or None without a table."""


@runtime_checkable
class OutcomeModel(Protocol):
    """Grid of parameters, with cells in C order and the threshold first."""

    @property
    def parameters(self) -> Mapping[str, tuple[float, ...]]: ...

    @property
    def n_outcomes(self) -> int: ...

    def log_likelihood(self, level: float, outcome: int) -> Array:
        """Return log P(outcome) at a level, (n_cells,)."""

    def likelihoods(self, levels: Sequence[float]) -> Likelihoods: ...


def size(model: OutcomeModel) -> tuple[int, int]:
    """Return the numbers of thresholds and of combinations of the others."""
    first, *rest = map(len, model.parameters.values())
    return first, math.prod(rest)


def p_log_p(p: Array) -> Array:
    """Return p log p, 0 where p is not above 0.

    >>> p_log_p(np.array([0.0, 1.0]))
    array([0., 0.])
    """
    return np.asarray(p * np.log(np.where(p > 0, p, 1.0)), dtype=np.float64)


@dataclass(frozen=True, eq=False)
class DenseLikelihoods:
    """Likelihoods in one table, (n_outcomes, n_levels, n_first, n_rest)."""

    table: Array

    def total(self, weights: Array) -> Array:
        return np.asarray(self.table.reshape(*self.table.shape[:2], -1) @ weights)

    def joint(self, weights: Array) -> Array:
        by_first = weights.reshape(*self.table.shape[2:], -1)
        joint = np.matmul(self.table.transpose(0, 2, 1, 3), by_first).transpose(0, 2, 1, 3)
        return np.asarray(joint if weights.ndim > 1 else joint[..., 0])

    @cached_property
    def logarithms(self) -> Array:
        """Log probabilities, (n_outcomes, n_levels, n_cells)."""
        with np.errstate(divide="ignore"):
            return np.asarray(np.log(self.table.reshape(*self.table.shape[:2], -1)))

    @cached_property
    def cost(self) -> Array:
        """Sum of p log p over outcomes, (n_levels, n_cells)."""
        return np.asarray(sum(map(p_log_p, self.table.reshape(*self.table.shape[:2], -1))))

    def log_likelihood(self, index: int, outcome: int) -> Array | None:
        del index, outcome
        return None

    def certainty(self, weights: Array) -> Array:
        return np.asarray(self.cost @ weights)


@dataclass(frozen=True, eq=False)
@constrained
class FunctionModel:
    """Model of any parameters and outcomes, by log probabilities.

    - `parameters`: Grid of each parameter by its name. The first parameter is the threshold.
    - `n_outcomes`: Number of answers, at least 2, reported to the procedure as 0, 1, ...
    - `log_probability`: ``log_probability(level, outcome, **parameters)`` for a float and for arrays that broadcast
      against each other. It returns log P(outcome), -inf if the outcome is impossible. The sum of P over the outcomes
      is 1.

    >>> def coin(level, outcome, *, bias):
    ...     return np.log(np.where(outcome == 1, bias, 1 - bias))
    >>> FunctionModel({"bias": (0.25, 0.75)}, 2, coin).log_likelihood(0.0, 1).round(3)
    array([-1.386, -0.288])
    """

    parameters: Mapping[str, tuple[float, ...]]
    n_outcomes: Annotated[int, Ge(2)]
    log_probability: Callable[..., Array]

    def __post_init__(self) -> None:
        of_kind("FunctionModel", Callable, log_probability=self.log_probability)
        _check_parameters("FunctionModel", self.parameters)

    def log_likelihood(self, level: float, outcome: int) -> Array:
        axes = dict(zip(self.parameters, np.ix_(*map(np.asarray, self.parameters.values())), strict=True))
        log_p = np.asarray(self.log_probability(level, outcome, **axes), dtype=np.float64)
        return np.broadcast_to(log_p, [len(values) for values in self.parameters.values()]).ravel()

    def likelihoods(self, levels: Sequence[float]) -> DenseLikelihoods:
        return tabulate(self, levels)


def tabulate(model: OutcomeModel, levels: Sequence[float]) -> DenseLikelihoods:
    """Tabulate a model at some levels; refuse sums of probabilities other than 1."""
    rows = [[np.exp(model.log_likelihood(level, outcome)) for level in levels] for outcome in range(model.n_outcomes)]
    table = np.array(rows).reshape(model.n_outcomes, len(levels), *size(model))
    for n, level in enumerate(levels):
        _check_sum(table[:, n].sum(axis=0), level)
    return DenseLikelihoods(table)


def _check_parameters(owner: str, parameters: Mapping[str, tuple[float, ...]]) -> None:
    of_kind(owner, Mapping, parameters=parameters)
    some(f"{owner}.parameters", parameters)
    for name, values in parameters.items():
        numbers(f"{owner}.parameters[{name!r}]", values)
        some(f"{owner}.parameters[{name!r}]", values)


def _check_sum(total: Array, level: float) -> None:
    away = np.abs(total - 1)
    worst = f"probabilities at level {level:g} that add up to {total.flat[int(away.argmax())]:g}"
    expect((away <= 1e-9).all(), "model", worst, "a sum of 1 over all outcomes")  # this also refuses NaN
