"""QUEST+: the level whose answer is expected to tell most."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import prod
from typing import Literal, get_args

import numpy as np

from tactometry.arguments.require import at_most, expect, numbers, of_kind, one_of

from .outcome_model import Array, Likelihoods, OutcomeModel, p_log_p, size
from .posterior import Posterior, log_prior
from .weighing import WeighingRule, WeighingRun

Aim = Literal["parameters", "threshold"]
Criterion = Literal["entropy", "variance"]
MOST_CHANCES = 100_000_000
"""What a table of one outcome may hold: 800 MB."""
TIE = 1e-12
"""Expected losses this near to the least are equal: the order of a sum must not decide where a session goes."""


@dataclass(frozen=True, eq=False)
class QuestPlus(WeighingRule):
    """Bayesian placement by minimum expected entropy or variance, for any model of answers.

    Watson, J. Vision 17(3):10 (2017). `aim` ``parameters`` is QUEST+: the entropy of the whole posterior, or the sum of
    the parameters' variances, each in units of its prior variance. ``threshold`` minimises the entropy or variance of
    the marginal of the first parameter, with the others as nuisance (Prins, J. Vision 13(7):3, 2013). Ties go to the
    first level.

    It ends after `n_trials`, or when the first parameter's posterior standard deviation is at most `sd_stop` (in the
    unit of the levels). Where that parameter is most likely the first or last of its grid, the answers tell a bound
    only and the run is censored. Answers that no cell of the grid allows end it as aborted; `remark` says which.

    Parameters
    ----------
    levels : tuple of float
        The candidates.
    grid : OutcomeModel
        `ParameterGrid`, or `FunctionModel`, `TableModel` for other parameters and more than two outcomes; the first
        parameter is the threshold.
    prior : mapping of str to sequence of float
        Weights of the values of a parameter, in any scale; flat for a parameter that is not named.

    Raises
    ------
    InvalidParameter
        If there are fewer than two levels, a level is not finite or stands twice, a number is out of its domain, or a
        prior does not fit.

    >>> from tactometry.protocols import ParameterGrid
    >>> rule = QuestPlus(
    ...     levels=tuple(range(-40, 1)), grid=ParameterGrid(tuple(range(-40, 1)), widths=(10.0,)), n_trials=2
    ... )
    >>> rule.level, rule.after(1).level, rule.after(1).after(0).ending
    (-17, -21, 'trials')
    """

    levels: tuple[float, ...]
    grid: OutcomeModel
    n_trials: int = 60
    sd_stop: float | None = None
    aim: Aim = "parameters"
    criterion: Criterion = "entropy"
    prior: Mapping[str, Sequence[float]] = field(default_factory=dict)

    name = "quest_plus"

    def __post_init__(self) -> None:
        numbers("QuestPlus.levels", self.levels)
        n_levels, n_different = len(self.levels), len(set(self.levels))
        listed = f"{n_levels} levels, {n_different} of them different"
        expect(n_levels == n_different >= 2, "QuestPlus.levels", listed, "at least two, each once")
        one_of("QuestPlus.aim", self.aim, get_args(Aim))
        one_of("QuestPlus.criterion", self.criterion, get_args(Criterion))
        of_kind("QuestPlus", OutcomeModel, grid=self.grid)
        n_combinations = prod(map(len, self.grid.parameters.values()))
        at_most("QuestPlus: levels times combinations of parameters", len(self.levels) * n_combinations, MOST_CHANCES)
        self._check_stop()
        # the first trial waits for neither the tables nor its level
        if self.aim == "parameters" and self.criterion == "entropy":
            self.likelihoods.prepare()
        _ = self.level, self.log_likelihood(self.levels[0], 0)

    @property
    def bounds(self) -> tuple[float, float]:
        return min(self.levels), max(self.levels)

    @property
    def n_outcomes(self) -> int:
        return self.grid.n_outcomes

    def begin(self, rng: np.random.Generator | None = None) -> "QuestPlusRun":
        del rng
        return QuestPlusRun(self, state=self.prior_state)

    @cached_property
    def likelihoods(self) -> Likelihoods:
        return self.grid.likelihoods(self.levels)

    @cached_property
    def prior_state(self) -> Posterior:
        prior = Posterior.of(log_prior(self.grid.parameters, self.prior, "QuestPlus"))
        assert prior is not None  # every parameter has a weight above 0
        return prior

    @cached_property
    def thresholds(self) -> Array:
        return np.asarray(next(iter(self.grid.parameters.values())), dtype=np.float64)

    @property
    def point(self) -> str:
        return "of the half point of its functions"

    def log_likelihood(self, level: float, outcome: int) -> Array:
        tabled = self.likelihoods.log_likelihood(self.levels.index(level), outcome) if level in self.levels else None
        return self.grid.log_likelihood(level, outcome) if tabled is None else tabled


@dataclass(frozen=True, eq=False)
class QuestPlusRun(WeighingRun[QuestPlus]):
    """Looks at every level for what its answer is expected to tell."""

    @property
    def posterior(self) -> Array:
        """Weights (n_first, n_rest) that add up to 1."""
        return self.state.weights.reshape(size(self.rule.grid))

    @property
    def marginal_of_threshold(self) -> Array:
        return np.asarray(self.posterior.sum(axis=1), dtype=np.float64)

    def marginal(self, parameter: str) -> Array:
        """The posterior of one parameter, (n_values,).

        Raises
        ------
        InvalidParameter
            If there is no such parameter.
        """
        names = list(self.rule.grid.parameters)
        one_of("QuestPlus.marginal", parameter, names)
        cells = self.state.weights.reshape([len(values) for values in self.rule.grid.parameters.values()])
        others = tuple(n for n, name in enumerate(names) if name != parameter)
        return np.asarray(cells.sum(axis=others), dtype=np.float64)

    def mean(self, parameter: str) -> float:
        """The posterior mean of one parameter."""
        return float(self.marginal(parameter) @ np.asarray(self.rule.grid.parameters[parameter]))

    @cached_property
    def level(self) -> float:
        """The level with the least expected loss; the first of equals."""
        losses = self.expected_loss()
        least = float(losses.min())
        return self.rule.levels[int((losses <= least + TIE * (1 + abs(least))).argmax())]

    def expected_loss(self) -> Array:
        """What is expected after one more answer at each level, (n_levels,): entropy (nat) or variance."""
        if self.rule.criterion == "variance":
            return self._variance()
        likelihoods, weights = self.rule.likelihoods, self.state.weights
        # No posterior of a possible answer is needed: H(cell | answer) = H(cell) + H(answer | cell) - H(answer), and
        # of the threshold alone H(threshold | answer) = H(threshold, answer) - H(answer).
        spread = _sum_p_log_p(likelihoods.total(weights))
        if self.rule.aim == "threshold":
            return np.asarray(spread - _sum_p_log_p(likelihoods.joint(weights)).sum(axis=1), dtype=np.float64)
        return spread - likelihoods.certainty(weights) + self.state.entropy

    def _variance(self) -> Array:
        """The expected variance of the first parameter, or the sum over all, each against that of its prior."""
        if self.rule.aim == "threshold":
            return self._variance_of(self._axis(0))
        axes = [self._axis(n) for n, values in enumerate(self.rule.grid.parameters.values()) if len(values) > 1]
        prior = self.rule.prior_state.weights
        spreads = [float(prior @ (axis - float(prior @ axis)) ** 2) for axis in axes]
        relative = [self._variance_of(axis) / spread for axis, spread in zip(axes, spreads, strict=True) if spread > 0]
        return sum(relative, start=np.zeros(len(self.rule.levels)))

    def _axis(self, n: int) -> Array:
        """The value of the nth parameter in each cell, (n_cells,)."""
        axes = np.meshgrid(*self.rule.grid.parameters.values(), indexing="ij")
        return np.asarray(axes[n], dtype=np.float64).ravel()

    def _variance_of(self, axis: Array) -> Array:
        weights = self.state.weights
        away = axis - float(weights @ axis)  # about the mean, so that the difference of squares keeps its digits
        mass, first, second = (self.rule.likelihoods.total(weights * away**power) for power in range(3))
        left: Array = second - first**2 / np.where(mass > 0, mass, 1.0)
        return np.asarray(np.where(mass > 0, left, 0.0).sum(axis=0), dtype=np.float64)

    @property
    def remark(self) -> str | None:
        """One sentence on a run that has no threshold."""
        first = next(iter(self.rule.grid.parameters))
        if self.ending == "aborted":
            return (
                f"QuestPlus.grid: found answer {self.responses[-1]} at level {self.delivered[-1]:g} in trial "
                f"{len(self.responses)}, which with the answers before it no cell of the grid allows, expected a grid "
                "that can; give it guess and lapse rates above 0 or a wider range"
            )
        if self.ending in ("censored_above", "censored_below"):
            end, bound = ("last", "above") if self.ending == "censored_above" else ("first", "below")
            return f"QuestPlus: the {end} {first} of the grid is the likeliest; the true one may lie {bound} it"
        return None


def _sum_p_log_p(probabilities: Array) -> Array:
    """Over outcomes, the first axis."""
    return np.asarray(p_log_p(probabilities).sum(axis=0), dtype=np.float64)
