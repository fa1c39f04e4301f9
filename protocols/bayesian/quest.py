"""QUEST: Bayesian estimation of one threshold."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from tactometry.arguments.constraints import Finite, Positive, Rate, constrained
from tactometry.arguments.require import expect, one_of
from tactometry.psychometric import shape_named

from ..procedures.procedure import Count
from .outcome_model import Array
from .parameter_grid import NARROWEST, ParameterGrid
from .weighing import Posterior, WeighingRule, WeighingRun

Placing = Literal["quantile", "mean", "mode"]
N_STEPS = 1_000_000
"""Steps of the finest grid, with which a trial takes about 0.1 s."""


@dataclass(frozen=True, eq=False)
@constrained
class Quest(WeighingRule):
    """Bayesian estimation of a threshold for a Weibull of known slope.

    The next level is the quantile, mean or mode of the posterior: Watson and Pelli, Perception & Psychophysics 33, 113
    (1983), in the form of Psychtoolbox and PsychoPy: ``P(1) = d g + (1 - d) (1 - (1 - g) exp(-10^(slope (x - t +
    e))))`` with x in decades of amplitude, g `guess_rate`, d `blind_share`, and e such that P(1) is `target` at the
    threshold t. The prior is normal, and the quantile is that of Pelli (1987) and King-Smith. Unlike PsychoPy's
    QuestHandler, the procedure does not round delivered levels to the grid. It ends as censored if the most likely
    threshold is at an end of the grid.

    - `start`: Mean of the prior of the threshold.
    - `start_sd`: Standard deviation of the prior of the threshold.
    - `low`: Lowest level, and lowest possible threshold.
    - `high`: Highest level, and highest possible threshold.
    - `step`: Distance between neighbouring thresholds of the grid.
    - `decade`: A factor of ten in amplitude, in the unit of the levels: 20 for decibels, 1 for log10.
    - `target`: Probability of the answer 1 at the threshold. 0.82 is the default of PsychoPy.
    - `slope`: Exponent of the Weibull function. The default is from Watson and Pelli.
    - `blind_share`: Fraction of answers given regardless of the stimulus. The default is from Watson and Pelli.
    - `guess_rate`: Probability of the answer 1 if nothing is felt.
    - `placing`: Statistic of the posterior that sets the next level.
    - `n_trials`: Largest number of trials of a track.
    - `sd_stop`: Standard deviation of the posterior at which a track ends, in the unit of the levels.

    >>> rule = Quest(start=20.0, start_sd=10.0, low=0.0, high=40.0, step=0.5, placing="mean")
    >>> rule.level, rule.after(1).level < 20 < rule.after(0).level
    (20.0, True)
    """

    start: Finite
    start_sd: Positive
    low: Finite
    high: Finite
    step: Positive
    decade: Positive = 20.0
    target: Finite = 0.82
    slope: Positive = 3.5
    guess_rate: Rate = 0.5
    blind_share: Rate = 0.01
    placing: Placing = "quantile"
    n_trials: Count = 40
    sd_stop: Positive | None = None

    name = "quest"

    def __post_init__(self) -> None:
        one_of("Quest.placing", self.placing, get_args(Placing))
        is_wide = self.start_sd >= NARROWEST * (self.high - self.low)
        expect(is_wide, "Quest.start_sd", f"{self.start_sd:g}", "a larger number, as the prior would be a point")

        n_steps = (self.high - self.low) / self.step
        is_grid = self.low <= self.start <= self.high and 1 <= n_steps <= N_STEPS
        numbers = f"{self.start:g}, low {self.low:g}, high {self.high:g} and step {self.step:g}"
        between = f"a start between low and high, and 1 to {N_STEPS} steps between them"
        expect(is_grid, "Quest.start", numbers, between)

        low, high = self.guess_rate, 1 - self.lapse_rate
        asymptotes = f"a probability between the asymptotes ({low:g} and {high:g})"
        expect(low < self.target < high, "Quest.target", f"{self.target:g}", asymptotes)

    def begin(self, rng: np.random.Generator | None = None) -> "QuestRun":
        del rng
        return QuestRun(self, state=self.prior_state)

    @cached_property
    def prior_state(self) -> Posterior:
        prior = Posterior.of(-0.5 * ((self.thresholds - self.start) / self.start_sd) ** 2)
        assert prior is not None  # every distance from the start is finite
        return prior

    @property
    def point(self) -> str:
        return f"at a chance of {self.target:.2f}"

    def places(self, log_weights: Array, weights: Array) -> Array:
        del log_weights
        if self.placing == "mean":
            placed = weights @ self.thresholds
        elif self.placing == "mode":
            placed = self.thresholds[weights.argmax(axis=1)]
        else:
            placed = self._quantiles(weights)
        return np.clip(placed, self.low, self.high)

    def _quantiles(self, weights: Array) -> Array:
        """Interpolate cumulative weights linearly between their increases."""
        summed, at = np.cumsum(weights, axis=1), np.arange(len(weights))
        orders = self.quantile_order * summed[:, -1]
        right = (summed < orders[:, None]).sum(axis=1)
        below = summed[at, np.maximum(right - 1, 0)]
        left = (summed < below[:, None]).sum(axis=1)
        reached = (right == 0) | (summed[at, right] == orders)
        rise = np.where(reached, 1.0, summed[at, right] - below)
        slope = (self.thresholds[right] - self.thresholds[left]) / rise
        return np.where(reached, self.thresholds[right], slope * (orders - below) + self.thresholds[left])

    def log_likelihoods(self, levels: Array, answers: NDArray[np.int8]) -> Array:
        distances, result = self.grid.distances(levels.tolist()), np.empty((len(levels), len(self.thresholds)))
        for answer in (0, 1):
            chosen = answers == answer
            result[chosen] = self.grid.log_likelihood_at(distances[chosen], answer).reshape(-1, len(self.thresholds))
        return result

    def log_likelihood(self, level: float, outcome: int) -> Array:
        return self.grid.log_likelihood(level, outcome)

    @property
    def lapse_rate(self) -> float:
        """Fraction of blind answers that are wrong."""
        return self.blind_share * (1 - self.guess_rate)

    @cached_property
    def thresholds(self) -> Array:
        """Grid of thresholds (n_thresholds,) in whole steps from `low`."""
        # 0.3 / 0.1 is less than 3, so a quotient of whole steps may need rounding up
        n_steps = math.floor((self.high - self.low) / self.step * (1 + 1e-12))
        return np.asarray(self.low + self.step * np.arange(n_steps + 1), dtype=np.float64)

    @cached_property
    def grid(self) -> ParameterGrid:
        """Grid of the same functions, by their half points."""
        gumbel, scale = shape_named("gumbel"), self.decade / (self.slope * math.log(10))
        unscaled = (self.target - self.guess_rate) / (1 - self.guess_rate - self.lapse_rate)
        # log(-log(1 - p)) is linear in the level, with a slope of 1 / `scale`
        to_half = (math.log(math.log(2)) - math.log(-math.log1p(-unscaled))) * scale
        half = tuple(float(threshold) + to_half for threshold in self.thresholds)
        return ParameterGrid(half, (gumbel.z_width * scale,), (self.guess_rate,), (self.lapse_rate,))

    @cached_property
    def quantile_order(self) -> float:
        """Position between the asymptotes at which an answer is most informative.

        There the entropy of the answer exceeds the straight line between its values at the asymptotes the most.
        """
        low, high = self.guess_rate, 1 - self.lapse_rate
        entropies = [-sum(q * math.log(q) for q in (p, 1 - p) if q > 0) for p in (low, high)]
        chord = (entropies[1] - entropies[0]) / (high - low)
        return (1 / (1 + math.exp(chord)) - low) / (high - low)


@dataclass(frozen=True, eq=False)
class QuestRun(WeighingRun[Quest]):
    """Run of a `Quest`."""

    @property
    def posterior(self) -> Array:
        """Weights (n_thresholds,) that add up to 1."""
        return self.state.weights

    @cached_property
    def level(self) -> float:
        return float(self.rule.places(self.state.log_weights[None], self.state.weights[None])[0])
