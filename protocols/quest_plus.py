"""QUEST+: the level whose answer is expected to tell most."""

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal, Self

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from tactometry.errors import InvalidParameter
from tactometry.protocols.parameter_grid import ParameterGrid, table
from tactometry.protocols.procedure import Ending, checked_response, refuse_finished

Array = NDArray[np.float64]
Aim = Literal["parameters", "threshold"]
EDGE_MASS = 0.5
"""Posterior mass of the first or last threshold above which a run counts as censored (unverified choice)."""


@dataclass(frozen=True, eq=False)
class QuestPlus:
    """Bayesian placement by minimum expected entropy, for answers 0 and 1.

    Watson, J. Vision 17(3):10 (2017). `aim` ``parameters`` is QUEST+: the entropy of the whole posterior, by two
    matrix-vector products. ``threshold`` minimises the entropy of the threshold's marginal, with width, guess and
    lapse rate as nuisance (Prins, J. Vision 13(7):3, 2013). Ties go to the first level. The prior is flat.

    It ends after `n_trials`, or when the threshold's posterior standard deviation is at most `sd_stop` (in the unit of
    the levels). Answers that no function of the grid allows end it as aborted.

    Raises
    ------
    InvalidParameter
        If there are fewer than two levels, a level is not finite or stands twice, or a number is out of its domain.

    >>> rule = QuestPlus(
    ...     levels=tuple(range(-40, 1)), grid=ParameterGrid(tuple(range(-40, 1)), widths=(10.0,)), n_trials=2
    ... )
    >>> rule.level, rule.after(1).level, rule.after(1).after(1).ended
    (-17, -21, 'trials')
    """

    levels: tuple[float, ...]
    grid: ParameterGrid
    n_trials: int = 60
    sd_stop: float | None = None
    aim: Aim = "parameters"
    responses: tuple[bool, ...] = ()
    delivered: tuple[float, ...] = ()
    log_weights: Array = field(default_factory=lambda: np.zeros(0), repr=False)
    contradicted: bool = False

    name = "quest_plus"

    def __post_init__(self) -> None:
        if len(self.levels) < 2 or len(set(self.levels)) != len(self.levels):
            raise InvalidParameter(
                f"QuestPlus.levels: found {len(self.levels)} levels, {len(set(self.levels))} of them different, "
                "expected at least two, each once"
            )
        if not all(map(math.isfinite, self.levels)):
            raise InvalidParameter(f"QuestPlus.levels: found {self.levels}, expected finite numbers")
        if self.n_trials < 1 or (self.sd_stop is not None and not self.sd_stop > 0):
            raise InvalidParameter(
                f"QuestPlus: found n_trials {self.n_trials} and sd_stop {self.sd_stop}, expected at least 1 and above 0"
            )
        if self.log_weights.size == 0:
            n_parameters = math.prod(self.grid.size)
            object.__setattr__(self, "log_weights", np.full(n_parameters, -math.log(n_parameters)))

    @cached_property
    def posterior(self) -> Array:
        """Weights (n_thresholds, n_others) that add up to 1."""
        return np.exp(self.log_weights).reshape(self.grid.size)

    @cached_property
    def level(self) -> float:
        """The level with the least expected entropy; the first of equals."""
        return self.levels[int(np.argmin(self.expected_entropy()))]

    def expected_entropy(self) -> Array:
        """Of the parameters or of the threshold's marginal (nat), after one more answer at each level, (n_levels,)."""
        return self._of_parameters() if self.aim == "parameters" else self._of_threshold()

    def _of_parameters(self) -> Array:
        chances, weights = table(self.grid, self.levels), self.posterior.ravel()
        certain = np.where(weights > 0, self.log_weights, 0.0)
        entropy: Array = -(chances.cost @ weights) - float(weights @ certain) + _spread(chances.yes @ weights)
        return entropy

    def _of_threshold(self) -> Array:
        chances = table(self.grid, self.levels)
        yes = (chances.yes * self.posterior.ravel()).reshape(len(self.levels), *self.grid.size).sum(axis=2)
        no = np.maximum(self.posterior.sum(axis=1) - yes, 0.0)
        entropy: Array = _spread(yes.sum(axis=1)) - _x_log_x(yes).sum(axis=1) - _x_log_x(no).sum(axis=1)
        return entropy

    @cached_property
    def threshold(self) -> float | None:
        """The posterior mean of the threshold; None for a censored or aborted run."""
        if self.ended in ("censored_above", "censored_below", "aborted"):
            return None
        return self._mean

    @cached_property
    def threshold_sd(self) -> float:
        """The posterior standard deviation of the threshold."""
        away = np.asarray(self.grid.thresholds) - self._mean
        return math.sqrt(float(self._marginal @ away**2))

    @property
    def _marginal(self) -> Array:
        marginal: Array = self.posterior.sum(axis=1)
        return marginal

    @property
    def _mean(self) -> float:
        return float(self._marginal @ np.asarray(self.grid.thresholds))

    @property
    def finished(self) -> bool:
        return self.ended is not None

    @cached_property
    def ended(self) -> Ending | None:
        if self.contradicted:
            return "aborted"
        converged = self.sd_stop is not None and bool(self.responses) and self.threshold_sd <= self.sd_stop
        if not converged and len(self.responses) < self.n_trials:
            return None
        if len(self.grid.thresholds) > 1 and (edge := self._edge()) is not None:
            return edge
        return "converged" if converged else "trials"

    def _edge(self) -> Ending | None:
        """Where the posterior leans on an end of its thresholds, which then say only a bound."""
        thresholds = np.asarray(self.grid.thresholds)
        if self._marginal[thresholds.argmax()] > EDGE_MASS:
            return "censored_above"
        return "censored_below" if self._marginal[thresholds.argmin()] > EDGE_MASS else None

    def after(self, response: int | bool, delivered: float | None = None) -> Self:
        """The posterior after an answer to the level that was delivered, on the grid or not."""
        yes = checked_response(response, "QuestPlus")
        refuse_finished(finished=self.finished, procedure="QuestPlus")
        level = self.level if delivered is None else delivered
        if not math.isfinite(level):
            raise InvalidParameter(f"QuestPlus.after: found the delivered level {level}, expected a finite number")
        log_yes, log_no = self.grid.log_chances([level])
        weights = self.log_weights + (log_yes if yes else log_no)[0]
        total = float(logsumexp(weights))
        possible = math.isfinite(total)
        return replace(
            self,
            responses=(*self.responses, yes),
            delivered=(*self.delivered, level),
            log_weights=weights - total if possible else self.log_weights,
            contradicted=not possible,
        )


def _x_log_x(x: Array) -> Array:
    return np.asarray(x * np.log(np.where(x > 0, x, 1.0)), dtype=np.float64)


def _spread(yes: Array) -> Array:
    """Sum over both answers of p log p, from p = P(1)."""
    return _x_log_x(yes) + _x_log_x(np.maximum(1 - yes, 0.0))
