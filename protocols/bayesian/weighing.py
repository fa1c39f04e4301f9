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
from numpy.typing import NDArray

from tactometry.arguments.require import expect, numbers, of_kind, one_of, positive, whole, without_none

from ..procedures.procedure import Ending, Rule, RuleThreshold, Run
from ..procedures.transition import CENSORED_ABOVE, CENSORED_BELOW, GOES_ON, ending_of
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
        return cls(*normalised(log_weights)) if math.isfinite(log_weights.max()) else None

    @property
    def entropy(self) -> float:
        """Nat; a weight of zero adds nothing."""
        return float(entropies(self.log_weights, self.weights))

    def after(self, log_likelihood: Array) -> Self | None:
        """After an answer with these log likelihoods, (n_cells,); None if no cell allows it."""
        return type(self).of(self.log_weights + log_likelihood)


def normalised(log_weights: Array) -> tuple[Array, Array]:
    """Log weights (..., n_cells) and weights that add up to 1 over the cells."""
    # the largest weight is 1 before they are divided: none overflows
    shifted = log_weights - log_weights.max(axis=-1, keepdims=True)
    weights = np.exp(shifted)
    total = weights.sum(axis=-1, keepdims=True)
    shifted -= np.log(total)
    weights /= total
    return shifted, weights


def entropies(log_weights: Array, weights: Array) -> Array:
    """Nat, (...), of stacks of weights (..., n_cells)."""
    return np.asarray(-np.einsum("...c,...c->...", weights, np.maximum(log_weights, LOWEST)))


def log_prior(parameters: Mapping[str, tuple[float, ...]], prior: Mapping[str, Sequence[float]], where: str) -> Array:
    """The sum of the parameters' log priors, (n_cells,); a parameter without one is flat.

    Raises `InvalidParameter` if a prior is of no parameter, of another length, or not of finite numbers from 0 with one
    above it.
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
    return ending_of(int(edges(values, marginal[None])[0]))


def edges(values: Array, marginals: Array) -> NDArray[np.int8]:
    """`edge` of each row of (n_sets, n_values), as codes of endings."""
    found = np.full(len(marginals), GOES_ON, dtype=np.int8)
    if len(values) < 2:
        return found
    for code, at in ((CENSORED_BELOW, int(values.argmin())), (CENSORED_ABOVE, int(values.argmax()))):
        found[marginals[:, at] > HIGHEST * np.delete(marginals, at, axis=1).max(axis=1)] = code
    return found


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
    learns_from_easy = True

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

    @abstractmethod
    def places(self, log_weights: Array, weights: Array) -> Array:
        """The next level (n_sets,) of each row of weights (n_sets, n_cells)."""

    @abstractmethod
    def log_likelihoods(self, levels: Array, answers: NDArray[np.int8]) -> Array:
        """log P(answer) at the level (n_sets,) of each set, (n_sets, n_cells)."""

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

    learns_from_easy = True

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
