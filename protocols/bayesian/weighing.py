"""Rules that weigh a grid of parameters.

Weights are kept as logarithms, so that very small weights can increase again.
"""

import math
from abc import abstractmethod
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..procedures.procedure import Ending, Rule, RuleThreshold, Run
from ..procedures.stepping import CENSORED_ABOVE, CENSORED_BELOW, CONVERGED, GOES_ON, TRIALS, ending_of
from .outcome_model import Array

HIGHEST = 1 + 1e-9
"""Factor by which the weight of an end must exceed all others to be the highest."""
LOWEST = -1e300
"""Replaces log 0 in a product with 0."""


@dataclass(frozen=True, eq=False)
class Posterior:
    """Normalised weights (n_cells,) and their logarithms."""

    log_weights: Array
    weights: Array

    @classmethod
    def of(cls, log_weights: Array) -> Self | None:
        """Normalise weights, or return None if every weight is zero.

        >>> Posterior.of(np.array([-2000.0, -2000.0])).weights
        array([0.5, 0.5])
        """
        return cls(*normalised(log_weights)) if math.isfinite(log_weights.max()) else None

    @property
    def entropy(self) -> float:
        """Entropy in nat."""
        return float(entropies(self.log_weights, self.weights))

    def after(self, log_likelihood: Array) -> Self | None:
        """Multiply by likelihoods (n_cells,), or return None if all become zero."""
        return type(self).of(self.log_weights + log_likelihood)


def normalised(log_weights: Array) -> tuple[Array, Array]:
    """Return log weights (..., n_cells) and weights that sum to 1."""
    shifted = log_weights - log_weights.max(axis=-1, keepdims=True)
    weights = np.exp(shifted)
    total = weights.sum(axis=-1, keepdims=True)
    shifted -= np.log(total)
    weights /= total
    return shifted, weights


def entropies(log_weights: Array, weights: Array) -> Array:
    """Return entropies (...) in nat of stacks of weights (..., n_cells)."""
    return np.asarray(-np.einsum("...c,...c->...", weights, np.maximum(log_weights, LOWEST)))


def judged(rule: "WeighingRule", weights: Array, n_answers: int) -> tuple[Array, Array, NDArray[np.int8]]:
    """Return mean, SD and ending of each row of weights (n_sets, n_cells)."""
    values = rule.thresholds
    marginals = weights.reshape(len(weights), len(values), -1).sum(axis=2)
    mean = marginals @ values
    sd = np.sqrt(np.einsum("st,st->s", marginals, (values - mean[:, None]) ** 2))

    at_end = TRIALS if n_answers >= rule.n_trials else GOES_ON
    sd_stop = -1.0 if rule.sd_stop is None else rule.sd_stop
    codes = np.where(sd <= sd_stop, CONVERGED, at_end).astype(np.int8)

    # a small spread at an end of the grid is caused by the grid: the run is censored, however it ended
    ends = {CENSORED_BELOW: values.argmin(), CENSORED_ABOVE: values.argmax()} if len(values) > 1 else {}
    for code, end in ends.items():
        is_highest = marginals[:, end] > HIGHEST * np.delete(marginals, end, axis=1).max(axis=1)
        codes[is_highest & (codes != GOES_ON)] = code
    return mean, sd, codes


class WeighingRule(Rule[Any]):
    """Settings of a rule that weighs parameters until `n_trials` or `sd_stop`."""

    sd_stop: float | None
    learns_from_easy = True

    @property
    @abstractmethod
    def prior_state(self) -> Posterior:
        """Weights of all cells before the first answer."""

    @property
    @abstractmethod
    def thresholds(self) -> Array:
        """Values of the threshold, (n_thresholds,)."""

    @property
    @abstractmethod
    def point(self) -> str:
        """Point of the functions at which the threshold is defined, in words."""

    @abstractmethod
    def log_likelihood(self, level: float, outcome: int) -> Array:
        """Return log P(outcome) at a level in each cell, (n_cells,)."""

    @abstractmethod
    def places(self, log_weights: Array, weights: Array) -> Array:
        """Return the next level (n_sets,) of each row of weights."""

    @abstractmethod
    def log_likelihoods(self, levels: Array, answers: NDArray[np.int8]) -> Array:
        """Return log P(answer) at each set's level, (n_sets, n_cells)."""


RuleT = TypeVar("RuleT", bound=WeighingRule)


@dataclass(frozen=True, eq=False)
class WeighingRun(Run[RuleT]):
    """Run with weights; `contradicted` if no cell allows the last answer."""

    state: Posterior = field(kw_only=True, repr=False)
    contradicted: bool = False

    learns_from_easy = True

    @cached_property
    def _judged(self) -> tuple[float, float, int]:
        mean, sd, codes = judged(self.rule, self.state.weights[None], len(self.responses))
        return float(mean[0]), float(sd[0]), int(codes[0])

    @property
    def mean_sd(self) -> tuple[float, float]:
        """Posterior mean of the threshold, and its standard deviation."""
        return self._judged[:2]

    @property
    def threshold_sd(self) -> float:
        """Posterior standard deviation of the threshold."""
        return self._judged[1]

    @property
    def ending(self) -> Ending | None:
        if self.contradicted:
            return "aborted"
        may_converge = self.rule.sd_stop is not None and self.responses
        if len(self.responses) < self.rule.n_trials and not may_converge:
            return None  # computed without the weights
        return ending_of(self._judged[2])

    def _estimate(self) -> RuleThreshold:
        return RuleThreshold(*self.mean_sd, len(self.responses), f"posterior mean {self.rule.point}")

    def _updated(self) -> Self:
        state = self.state.after(self.rule.log_likelihood(self.delivered[-1], self.responses[-1]))
        return replace(self, state=state or self.state, contradicted=state is None)
