"""What all rules that weigh a grid of parameters share: when they end, and what they make of the threshold."""

from abc import abstractmethod
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Self, TypeVar

import numpy as np

from tactometry.arguments.require import given, positive, whole

from ..procedures.procedure import Ending, Rule, RuleThreshold, Run
from .outcome_model import Array
from .posterior import Posterior, edge, mean_sd


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
        positive(owner, **given({"sd_stop": self.sd_stop}))


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
