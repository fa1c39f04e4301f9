"""QUEST+ and the psi method with plain numbers, as in a study file."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, get_args

import numpy as np

from tactometry.arguments.constraints import Rate, constrained, excerpt, is_number
from tactometry.arguments.require import below, expect, finite, numbers, one_of, whole, without_none

from .parameter_grid import ParameterGrid
from .quest_plus import Aim, Criterion, QuestPlus

Spacing = Literal["linear", "log"]
MOST_VALUES = 10_000
"""Largest number of values in one grid."""


def grid_values(owner: str, spacing: Spacing, **grid: float) -> tuple[float, ...]:
    """Return values with equal steps or ratios from low, high and number.

    Raises `InvalidParameter` if the values do not increase. The message begins with `owner` and the name.

    >>> grid_values("levels", "log", low=1.0, high=100.0, n=3)
    (1.0, 10.0, 100.0)
    """
    (of_low, low), (of_high, high), (of_n, n) = grid.items()
    finite(owner, **{of_low: low, of_high: high})
    whole(owner, lowest=1, highest=MOST_VALUES, **{of_n: n})
    one_of(f"{owner}.spacing", spacing, get_args(Spacing))
    if n > 1:
        below(owner, **{of_low: low, of_high: high})
    if spacing == "log":
        expect(low > 0, f"{owner}.{of_low}", f"{low:g}", "above 0 (values with equal ratios)")
    if n == 1:
        return (low,)
    spaced = np.linspace if spacing == "linear" else np.geomspace
    return tuple(spaced(low, high, int(n)).tolist())


@dataclass(frozen=True)
class QuestPlusSettings:
    """QUEST+: place each trial where its expected information is largest.

    - `low`: Lowest level that is presented.
    - `high`: Highest level that is presented.
    - `n_levels`: Number of levels from `low` to `high`.
    - `spacing`: ``linear`` for levels in decibels, ``log`` for levels above 0 in a linear unit (with the shape
      ``weibull``).
    - `width_low`: Smallest possible width, in the unit of the levels, or in natural logarithms for ``weibull``.
    - `width_high`: Largest possible width, in the same unit.
    - `n_widths`: Number of widths from `width_low` to `width_high`, with equal ratios.
    - `width_prior_factor`: Factor of one standard deviation, above 1, of a log-normal prior of the widths about the
      geometric mean of their grid. Without it the prior is flat on the grid.
    - `threshold_low`: Lowest possible threshold. The default is the lowest level.
    - `threshold_high`: Highest possible threshold. The default is the highest level.
    - `n_thresholds`: Number of thresholds in this range. The default is `n_levels`.
    - `shape`: Shape of the psychometric function: ``gumbel``, ``normal``, ``logistic``, ``reversed_gumbel`` or
      ``weibull``.
    - `guess_rates`: Possible guess rates. A single one is treated as known.
    - `lapse_rates`: Possible lapse rates. A single one is treated as known.
    - `n_trials`: Largest number of trials of a track.
    - `sd_stop`: Standard deviation of the threshold at which a track ends, in the unit of the levels.
    - `aim`: Quantity to estimate: the threshold alone, or all parameters.
    - `criterion`: Measure of its uncertainty that the next level minimises.

    >>> settings = QuestPlusSettings(low=0.0, high=40.0, n_levels=41, width_low=4.0, width_high=16.0, n_widths=3)
    >>> rule = settings.procedure()
    >>> rule.levels[:3], rule.grid.size
    ((0.0, 1.0, 2.0), (41, 9))
    """

    low: float
    high: float
    n_levels: int
    width_low: float
    width_high: float
    n_widths: int = 10
    width_prior_factor: float | None = None
    spacing: Spacing = "linear"
    shape: str = "gumbel"
    guess_rates: tuple[float, ...] = (0.5,)
    lapse_rates: tuple[float, ...] = (0.0, 0.02, 0.05)
    threshold_low: float | None = None
    threshold_high: float | None = None
    n_thresholds: int | None = None
    n_trials: int = 60
    sd_stop: float | None = None
    aim: Aim = "threshold"
    criterion: Criterion = "entropy"

    def __post_init__(self) -> None:
        _ = self._levels, self._grid

    @cached_property
    def _levels(self) -> tuple[float, ...]:
        return grid_values("QuestPlusSettings", self.spacing, low=self.low, high=self.high, n_levels=self.n_levels)

    @cached_property
    def _grid(self) -> ParameterGrid:
        as_levels = {"threshold_low": self.low, "threshold_high": self.high, "n_thresholds": self.n_levels}
        stated = without_none({name: getattr(self, name) for name in as_levels})
        thresholds = grid_values("QuestPlusSettings", self.spacing, **as_levels | stated)
        bounds = {"width_low": self.width_low, "width_high": self.width_high, "n_widths": self.n_widths}
        widths = grid_values("QuestPlusSettings", "log", **bounds)
        return ParameterGrid(thresholds, widths, self.guess_rates, self.lapse_rates, self.shape)

    def procedure(self) -> QuestPlus:
        prior = {} if self.width_prior_factor is None else {"width": self._width_prior(self.width_prior_factor)}
        return QuestPlus(self._levels, self._grid, self.n_trials, self.sd_stop, self.aim, self.criterion, prior)

    def _width_prior(self, factor: float) -> tuple[float, ...]:
        is_factor = is_number(factor) and factor > 1
        expect(is_factor, "QuestPlusSettings.width_prior_factor", excerpt(factor), "a number above 1")
        widths = np.log(self._grid.widths)
        weights = np.exp(-0.5 * ((widths - (widths[0] + widths[-1]) / 2) / math.log(factor)) ** 2)
        return tuple(weights.tolist())


@dataclass(frozen=True)
@constrained
class PsiSettings:
    """Psi method: QUEST+ for threshold and slope of a cumulative normal.

    The guess and lapse rates are known. Kontsevich and Tyler, Vision Research 39, 2729 (1999). Levels and thresholds
    share one grid with equal steps. Standard deviations (the inverse slopes) have equal ratios. The prior is flat on
    both. Each level minimises the expected entropy of threshold and slope together, or with `psi_marginal` that of the
    threshold alone (Prins 2013).

    - `low`: Lowest level, and lowest possible threshold.
    - `high`: Highest level, and highest possible threshold.
    - `n_levels`: Number of levels, and of thresholds, from `low` to `high`.
    - `sd_low`: Smallest possible standard deviation of the normal, in the unit of the levels.
    - `sd_high`: Largest possible standard deviation of the normal, in the unit of the levels.
    - `n_sds`: Number of standard deviations from `sd_low` to `sd_high`.
    - `guess_rate`: Known guess rate. 0.5 applies to two-interval forced choice (unverified default).
    - `lapse_rate`: Known lapse rate. 0.02 applies to 4 % blind answers in two intervals (unverified default).
    - `psi_marginal`: True to estimate only the threshold.
    - `n_trials`: Largest number of trials of a track.
    - `sd_stop`: Standard deviation of the threshold at which a track ends, in the unit of the levels.

    >>> PsiSettings(low=0.0, high=40.0, n_levels=41, sd_low=1.0, sd_high=8.0, n_sds=4).procedure().level
    23.0
    """

    low: float
    high: float
    n_levels: int
    sd_low: float
    sd_high: float
    n_sds: int = 20
    guess_rate: Rate = 0.5
    lapse_rate: Rate = 0.02
    psi_marginal: bool = False
    n_trials: int = 60
    sd_stop: float | None = None

    def __post_init__(self) -> None:
        _ = self._levels, self._sds

    @cached_property
    def _levels(self) -> tuple[float, ...]:
        return grid_values("PsiSettings", "linear", low=self.low, high=self.high, n_levels=self.n_levels)

    @cached_property
    def _sds(self) -> tuple[float, ...]:
        return grid_values("PsiSettings", "log", sd_low=self.sd_low, sd_high=self.sd_high, n_sds=self.n_sds)

    def procedure(self) -> QuestPlus:
        return psi(
            self._levels,
            self._levels,
            self._sds,
            guess_rate=self.guess_rate,
            lapse_rate=self.lapse_rate,
            n_trials=self.n_trials,
            sd_stop=self.sd_stop,
            aim="threshold" if self.psi_marginal else "parameters",
        )


def psi(
    levels: tuple[float, ...],
    thresholds: tuple[float, ...],
    sds: tuple[float, ...],
    *,
    guess_rate: float,
    lapse_rate: float,
    n_trials: int,
    sd_stop: float | None = None,
    aim: Aim = "parameters",
) -> QuestPlus:
    """Return the psi method on any grids, see `PsiSettings`.

    >>> psi((0.0, 1.0), (0.0, 1.0), (0.5, 1.0), guess_rate=0.5, lapse_rate=0.02, n_trials=20).name
    'quest_plus'
    """
    numbers("psi.sds", sds)
    sd_to_width = 2 * 1.6448536269514722  # from the 0.05 to the 0.95 point of the normal
    widths = tuple(sd_to_width * sd for sd in sds)
    grid = ParameterGrid(thresholds, widths, (guess_rate,), (lapse_rate,), shape="normal")
    return QuestPlus(levels, grid, n_trials=n_trials, sd_stop=sd_stop, aim=aim)
