"""QUEST: a Bayesian estimate of one threshold, presented where it stands."""

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal, Self, get_args

import numpy as np
from numpy.typing import NDArray

from tactometry.arguments.require import below_1, finite, one_of, positive
from tactometry.errors import InvalidParameter
from tactometry.psychometric import shape_named

from ..procedures.procedure import Ending, checked_response, finite_level, refuse_finished
from .parameter_grid import NARROWEST, ParameterGrid
from .posterior import Posterior, Stop, mean_sd

Array = NDArray[np.float64]
Placing = Literal["quantile", "mean", "mode"]
N_STEPS = 1_000_000
"""Of the finest grid: a trial then takes about a tenth of a second."""


@dataclass(frozen=True, eq=False)
class Quest:
    """The threshold's posterior under a Weibull function of known slope; the next level is its quantile, mean or mode.

    Watson and Pelli, Perception & Psychophysics 33, 113 (1983), in the form of Psychtoolbox and PsychoPy:
    ``P(1) = d g + (1 - d) (1 - (1 - g) exp(-10^(slope (x - t + e))))`` with x in decades of amplitude, g `guess_rate`,
    d `blind_share`, and e such that P(1) is `target` at the threshold t. The prior is normal. The quantile is the one
    of Pelli (1987) and King-Smith, which depends on the two asymptotes only.

    Differences from PsychoPy's QuestHandler: the level that was delivered counts as it is, not rounded to the grid; and
    where the likeliest threshold is an end of the grid the run is censored.

    Parameters
    ----------
    start, start_sd : float
        Mean and standard deviation of the prior.
    low, high, step : float
        Grid of thresholds, and the bounds of the levels.
    decade : float
        A factor of ten in amplitude, in the unit of the levels: 20 for decibels, 1 for log10.
    target : float
        Chance of the answer 1 at the threshold. 0.82 is PsychoPy's.
    slope, blind_share : float
        The defaults are Watson and Pelli's.

    Raises
    ------
    InvalidParameter
        If a number is out of its domain.

    >>> rule = Quest(start=20.0, start_sd=10.0, low=0.0, high=40.0, step=0.5, placing="mean")
    >>> rule.level, rule.after(1).level < 20 < rule.after(0).level
    (20.0, True)
    """

    start: float
    start_sd: float
    low: float
    high: float
    step: float
    decade: float = 20.0
    target: float = 0.82
    slope: float = 3.5
    guess_rate: float = 0.5
    blind_share: float = 0.01
    placing: Placing = "quantile"
    n_trials: int = 40
    sd_stop: float | None = None
    responses: tuple[bool, ...] = ()
    delivered: tuple[float, ...] = ()
    contradicted: bool = False
    state: Posterior | None = field(default=None, repr=False)
    grid: ParameterGrid | None = field(default=None, repr=False)

    name = "quest"

    def __post_init__(self) -> None:
        if self.state is not None:
            return
        self._check()
        object.__setattr__(self, "grid", self._grid())
        object.__setattr__(self, "state", Posterior.of(-0.5 * ((self.thresholds - self.start) / self.start_sd) ** 2))

    def _check(self) -> None:
        one_of("Quest.placing", self.placing, get_args(Placing))
        finite("Quest", start=self.start, low=self.low, high=self.high, target=self.target)
        finite("Quest", guess_rate=self.guess_rate, blind_share=self.blind_share)
        positive("Quest", start_sd=self.start_sd, step=self.step, decade=self.decade, slope=self.slope)
        if self.start_sd < NARROWEST * (self.high - self.low):
            raise InvalidParameter(f"Quest.start_sd: found {self.start_sd:g}, expected more; the prior is a point")
        Stop(self.n_trials, self.sd_stop).check("Quest")
        if not self.low <= self.start <= self.high or not 1 <= (self.high - self.low) / self.step <= N_STEPS:
            raise InvalidParameter(
                f"Quest.start: found {self.start:g}, low {self.low:g}, high {self.high:g} and step {self.step:g}, "
                f"expected a start between low and high, which are 1 to {N_STEPS} steps apart"
            )
        self._check_rates()

    def _check_rates(self) -> None:
        below_1("Quest", guess_rate=self.guess_rate, blind_share=self.blind_share)
        if not self.guess_rate < self.target < 1 - self.lapse_rate:
            raise InvalidParameter(
                f"Quest.target: found {self.target:g}, expected a chance between the asymptotes "
                f"({self.guess_rate:g} and {1 - self.lapse_rate:g})"
            )

    @property
    def lapse_rate(self) -> float:
        """Of a blind press the part that is not a lucky guess."""
        return self.blind_share * (1 - self.guess_rate)

    @cached_property
    def thresholds(self) -> Array:
        """The grid: whole steps from `low`, `high` the last if a step falls on it, (n_thresholds,)."""
        n_steps = math.floor((self.high - self.low) / self.step * (1 + 1e-12))
        return np.asarray(self.low + self.step * np.arange(n_steps + 1), dtype=np.float64)

    def _grid(self) -> ParameterGrid:
        """The same functions by their half points."""
        gumbel, scale = shape_named("gumbel"), self.decade / (self.slope * math.log(10))
        unscaled = (self.target - self.guess_rate) / (1 - self.guess_rate - self.lapse_rate)
        to_half = (math.log(math.log(2)) - math.log(-math.log1p(-unscaled))) * scale
        half = tuple(float(threshold) + to_half for threshold in self.thresholds)
        return ParameterGrid(half, (gumbel.z_width * scale,), (self.guess_rate,), (self.lapse_rate,))

    @property
    def posterior(self) -> Array:
        """Weights of `thresholds` that add up to 1."""
        assert self.state is not None
        return self.state.weights

    @cached_property
    def level(self) -> float:
        placed = {"mean": self._mean, "mode": self._mode, "quantile": self._quantile}[self.placing]()
        return min(max(placed, self.low), self.high)

    def _mean(self) -> float:
        return mean_sd(self.thresholds, self.posterior)[0]

    def _mode(self) -> float:
        return float(self.thresholds[int(self.posterior.argmax())])

    def _quantile(self) -> float:
        summed = np.cumsum(self.posterior)
        rising = np.flatnonzero(np.diff(summed, prepend=-1.0))
        return float(np.interp(self.quantile_order * summed[-1], summed[rising], self.thresholds[rising]))

    @cached_property
    def quantile_order(self) -> float:
        """Between the asymptotes, the part at which an answer tells most: where the entropy of the answer exceeds the
        chord between its values at the asymptotes by most."""
        low, high = self.guess_rate, 1 - self.lapse_rate
        chord = (_binary_entropy(high) - _binary_entropy(low)) / (high - low)
        return (1 / (1 + math.exp(chord)) - low) / (high - low)

    @cached_property
    def threshold(self) -> float | None:
        """The posterior mean, at which P(1) is `target`; None for a censored or aborted run."""
        return None if self.ended in ("censored_above", "censored_below", "aborted") else self._mean()

    @cached_property
    def threshold_sd(self) -> float:
        """The posterior standard deviation."""
        return mean_sd(self.thresholds, self.posterior)[1]

    @property
    def finished(self) -> bool:
        return self.ended is not None

    @cached_property
    def ended(self) -> Ending | None:
        stop, n_told = Stop(self.n_trials, self.sd_stop), len(self.responses)
        return stop.ending(lambda: (self.thresholds, self.posterior), n_told=n_told, contradicted=self.contradicted)

    def after(self, response: int | bool, delivered: float | None = None) -> Self:
        """The posterior after an answer to the level that was delivered (default: the one asked for)."""
        yes = checked_response(response, "Quest")
        refuse_finished(finished=self.finished, procedure="Quest")
        level = finite_level(self.level if delivered is None else delivered, "Quest")
        assert self.state is not None
        assert self.grid is not None
        state = self.state.after(self.grid.log_chance(level, int(yes)))
        return replace(
            self,
            responses=(*self.responses, yes),
            delivered=(*self.delivered, level),
            state=state or self.state,
            contradicted=state is None,
        )


def _binary_entropy(p: float) -> float:
    return -sum(q * math.log(q) for q in (p, 1 - p) if q > 0)
