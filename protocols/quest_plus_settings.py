"""QUEST+ and the psi method from plain numbers, as a study file gives them."""

import math
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from tactometry.errors import InvalidParameter
from tactometry.protocols.parameter_grid import ParameterGrid
from tactometry.protocols.quest_plus import Aim, Criterion, QuestPlus
from tactometry.require import finite, is_number, numbers, one_of, whole

Spacing = Literal["linear", "log"]
MOST_VALUES = 10_000
"""Of one grid."""


def spaced(low: float, high: float, n: int, spacing: Spacing, where: str) -> tuple[float, ...]:
    """`n` values from `low` to `high`, with equal steps or equal ratios.

    Raises
    ------
    InvalidParameter
        If they make no rising grid; `where` opens the sentence.

    >>> spaced(1.0, 100.0, 3, "log", "levels")
    (1.0, 10.0, 100.0)
    """
    finite(where, low=low, high=high)
    whole(where, lowest=1, highest=MOST_VALUES, n=n)
    one_of(f"{where}.spacing", spacing, get_args(Spacing))
    if n > 1 and not low < high:
        raise InvalidParameter(f"{where}: found {n} values from {low:g} to {high:g}, expected a rising grid")
    if spacing == "log" and low <= 0:
        raise InvalidParameter(f"{where}: found a log grid from {low:g}, expected one that begins above 0")
    if n == 1:
        return (low,)
    grid = np.linspace(low, high, n) if spacing == "linear" else np.geomspace(low, high, n)
    return tuple(float(value) for value in grid)


@dataclass(frozen=True)
class QuestPlusSettings:
    """The numbers of a `QuestPlus` over a `ParameterGrid`; `procedure()` makes it.

    Parameters
    ----------
    low, high : float
        Bounds of the levels.
    n_levels : int
        How many there are.
    spacing : str
        ``linear`` for levels in decibels, ``log`` for levels above 0 in a linear unit (with the shape ``weibull``).
    width_low, width_high, n_widths
        Widths, with equal ratios. In the unit of the levels, or in natural logarithms for ``weibull``.
    width_prior_factor : float
        If given, the widths' prior is log-normal about the geometric middle of their grid with this factor, above 1,
        for a standard deviation; else it is flat on the grid.
    threshold_low, threshold_high, n_thresholds
        Thresholds; as the levels where they are not given.

    Raises
    ------
    InvalidParameter
        As `QuestPlus` and `ParameterGrid`, or if a grid does not rise.

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

    def procedure(self) -> QuestPlus:
        levels, grid = self._levels(), self._grid()
        prior = {} if self.width_prior_factor is None else {"width": self._width_prior(grid.widths)}
        return QuestPlus(levels, grid, self.n_trials, self.sd_stop, self.aim, self.criterion, prior)

    def _width_prior(self, widths: tuple[float, ...]) -> tuple[float, ...]:
        factor = self.width_prior_factor
        if not is_number(factor) or factor <= 1:
            raise InvalidParameter(
                f"QuestPlusSettings.width_prior_factor: found {factor!r:.60}, expected a number above 1"
            )
        middle = math.sqrt(widths[0]) * math.sqrt(widths[-1])
        return tuple(math.exp(-0.5 * (math.log(width / middle) / math.log(factor)) ** 2) for width in widths)

    def _levels(self) -> tuple[float, ...]:
        return spaced(self.low, self.high, self.n_levels, self.spacing, "QuestPlusSettings.levels")

    def _grid(self) -> ParameterGrid:
        thresholds = spaced(
            self.low if self.threshold_low is None else self.threshold_low,
            self.high if self.threshold_high is None else self.threshold_high,
            self.n_levels if self.n_thresholds is None else self.n_thresholds,
            self.spacing,
            "QuestPlusSettings.thresholds",
        )
        widths = spaced(self.width_low, self.width_high, self.n_widths, "log", "QuestPlusSettings.widths")
        return ParameterGrid(thresholds, widths, self.guess_rates, self.lapse_rates, self.shape)


@dataclass(frozen=True)
class PsiSettings:
    """The psi method: QUEST+ for threshold and slope of a cumulative normal, guess and lapse rate known.

    Kontsevich and Tyler, Vision Research 39, 2729 (1999). Levels and thresholds share one grid with equal steps,
    standard deviations (the inverse slopes) have equal ratios, the prior is flat on both, and the expected entropy of
    threshold and slope together is least. `psi_marginal` minimises that of the threshold alone (Prins 2013).

    Parameters
    ----------
    low, high, n_levels
        Levels and thresholds.
    sd_low, sd_high, n_sds
        Standard deviations of the normal, in the unit of the levels.
    guess_rate, lapse_rate : float
        0.5 and 0.02 are those of a 4 % share of blind answers in two-interval forced choice (unverified default).

    Raises
    ------
    InvalidParameter
        As `QuestPlus` and `ParameterGrid`, or if a grid does not rise.

    >>> PsiSettings(low=0.0, high=40.0, n_levels=41, sd_low=1.0, sd_high=8.0, n_sds=4).procedure().level
    23.0
    """

    low: float
    high: float
    n_levels: int
    sd_low: float
    sd_high: float
    n_sds: int = 20
    guess_rate: float = 0.5
    lapse_rate: float = 0.02
    psi_marginal: bool = False
    n_trials: int = 60
    sd_stop: float | None = None

    def procedure(self) -> QuestPlus:
        levels = spaced(self.low, self.high, self.n_levels, "linear", "PsiSettings.levels")
        sds = spaced(self.sd_low, self.sd_high, self.n_sds, "log", "PsiSettings.sds")
        return psi(
            levels,
            levels,
            sds,
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
    """The psi method on any grids: `PsiSettings` says what it is.

    >>> psi((0.0, 1.0), (0.0, 1.0), (0.5, 1.0), guess_rate=0.5, lapse_rate=0.02, n_trials=20).name
    'quest_plus'
    """
    numbers("psi.sds", sds)
    sd_to_width = 2 * 1.6448536269514722
    widths = tuple(sd_to_width * sd for sd in sds)
    grid = ParameterGrid(thresholds, widths, (guess_rate,), (lapse_rate,), shape="normal")
    return QuestPlus(levels, grid, n_trials=n_trials, sd_stop=sd_stop, aim=aim)
