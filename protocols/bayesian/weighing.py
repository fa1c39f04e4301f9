"""Rules that weigh a grid of parameters: its weights, when such a rule ends, and what it makes of the threshold.

Weights are in log space throughout, so that no cell is lost that may come back.
"""

import math
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Self, TypeVar

import numpy as np

from tactometry.arguments.require import expect, numbers, of_kind, one_of, positive, whole, without_none

from ..procedures.procedure import Ending, Rule, RuleThreshold, Run
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
        known = np.asarray(weights, dtype=np.float64)
        n_values = len(parameters[name])
        are_weights = known.shape == (n_values,) and (known >= 0).all() and 0 < known.sum() < math.inf
        listed = f"{len(weights)} weights from {known.min(initial=0):g} on"
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
    ends: dict[Ending, int] = {"censored_above": int(values.argmax()), "censored_below": int(values.argmin())}
    for ending, at in ends.items():
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


class WeighingRule(Rule[Any]):
    """Numbers of a rule that asks until `n_trials`, or until the posterior standard deviation of the threshold is at
    most `sd_stop`."""

    sd_stop: float | None

    @property
    @abstractmethod
    def prior_state(self) -> Posterior:
        """Of all cells, before the first answer."""

    @property
    @abstractmethod
    def thresholds(self) -> Array:
        """The values of the threshold, (n_thresholds,)."""

    @property
    @abstractmethod
    def point(self) -> str:
        """Of its functions, at which the threshold lies, in words."""

    @abstractmethod
    def log_likelihood(self, level: float, outcome: int) -> Array:
        """log P(outcome) at a level in each cell, (n_cells,)."""

    def _check_stop(self) -> None:
        """Refuse what never ends."""
        owner = type(self).__name__
        whole(owner, lowest=1, n_trials=self.n_trials)
        positive(owner, **without_none({"sd_stop": self.sd_stop}))


RuleT = TypeVar("RuleT", bound=WeighingRule)


@dataclass(frozen=True, eq=False)
class WeighingRun(Run[RuleT]):
    """The weights of all cells after the answers (`state`); those of before where no cell allows the last one
    (`contradicted`)."""

    state: Posterior = field(kw_only=True, repr=False)
    contradicted: bool = False

    @property
    def marginal_of_threshold(self) -> Array:
        """Weights of the thresholds that add up to 1, (n_thresholds,)."""
        return np.asarray(self.state.weights.reshape(len(self.rule.thresholds), -1).sum(axis=1), dtype=np.float64)

    @cached_property
    def mean_sd(self) -> tuple[float, float]:
        """The posterior mean of the threshold, and its standard deviation."""
        return mean_sd(self.rule.thresholds, self.marginal_of_threshold)

    @property
    def threshold_sd(self) -> float:
        """The posterior standard deviation of the threshold."""
        return self.mean_sd[1]

    @cached_property
    def ending(self) -> Ending | None:
        if self.contradicted:
            return "aborted"
        last, sd_stop = len(self.responses) >= self.rule.n_trials, self.rule.sd_stop
        if not last and (sd_stop is None or not self.responses):
            return None  # without a look at the weights, which most trials need not take
        converged = sd_stop is not None and self.threshold_sd <= sd_stop
        if not (last or converged):
            return None
        # At an end of the grid a small spread is the grid's own: the run is censored, however it ended.
        return edge(self.rule.thresholds, self.marginal_of_threshold) or ("converged" if converged else "trials")

    def _estimate(self) -> RuleThreshold:
        return RuleThreshold(*self.mean_sd, len(self.responses), f"posterior mean {self.rule.point}")

    def _updated(self) -> Self:
        state = self.state.after(self.rule.log_likelihood(self.delivered[-1], self.responses[-1]))
        return replace(self, state=state or self.state, contradicted=state is None)
