"""The grid of psychometric functions that a Bayesian procedure weighs."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from tactometry.errors import InvalidParameter
from tactometry.psychometric import log_mixture, shape_named

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ParameterGrid:
    """All combinations of thresholds, widths, guess and lapse rates of one shape.

    Threshold and width as in `tactometry.psychometric` (half of the unscaled function; its 0.05 to 0.95 points). In
    decibels the shape ``gumbel`` is Weibull's function of the amplitude.

    Raises
    ------
    InvalidParameter
        If a list is empty, holds a value twice, or a value that is not of its domain, or guess and lapse rates leave
        nothing between them.
    """

    thresholds: tuple[float, ...]
    widths: tuple[float, ...]
    guess_rates: tuple[float, ...] = (0.5,)
    lapse_rates: tuple[float, ...] = (0.02,)
    shape: str = "gumbel"

    def __post_init__(self) -> None:
        shape_named(self.shape)
        _check("thresholds", self.thresholds, -math.inf, math.inf)
        _check("widths", self.widths, 0, math.inf)
        _check("guess_rates", self.guess_rates, -1e-300, 1)
        _check("lapse_rates", self.lapse_rates, -1e-300, 1)
        if max(self.guess_rates) + max(self.lapse_rates) >= 1:
            raise InvalidParameter(
                f"ParameterGrid.lapse_rates: found guess and lapse rates that add up to "
                f"{max(self.guess_rates) + max(self.lapse_rates):g}, expected less than 1"
            )

    @property
    def size(self) -> tuple[int, int]:
        """(n_thresholds, n_others)."""
        return len(self.thresholds), len(self.widths) * len(self.guess_rates) * len(self.lapse_rates)

    def log_chances(self, levels: Sequence[float]) -> tuple[Array, Array]:
        """log P(1) and log P(0), each (n_levels, n_parameters), thresholds slowest."""
        shape = shape_named(self.shape)
        axes = (self.thresholds, self.widths, self.guess_rates, self.lapse_rates)
        t, w, g, lapse = (grid.ravel() for grid in np.meshgrid(*axes, indexing="ij"))
        z = shape.z50 + (np.asarray(levels)[:, None] - t) / w * shape.z_width
        return log_mixture(shape.log_cdf(z), shape.log_sf(z), g, lapse)


def _check(name: str, values: tuple[float, ...], low: float, high: float) -> None:
    if not values:
        raise InvalidParameter(f"ParameterGrid.{name}: found no value, expected at least one")
    for n, value in enumerate(values):
        if not low < value < high:
            where = "" if low == -math.inf else f" between {max(low, 0):g} and {high:g}"
            raise InvalidParameter(f"ParameterGrid.{name}[{n}]: found {value}, expected a finite number{where}")
        if value in values[:n]:
            raise InvalidParameter(f"ParameterGrid.{name}[{n}]: found {value:g} twice, expected each value once")


@dataclass(frozen=True, eq=False)
class Table:
    """Chances of a grid at the candidate levels: `yes` = P(1) and `cost` = sum over answers of P log P, both
    (n_levels, n_parameters)."""

    yes: Array
    cost: Array


@lru_cache(maxsize=8)
def table(grid: ParameterGrid, levels: tuple[float, ...]) -> Table:
    """The table of a grid, computed once for all participants of a study."""
    log_yes, log_no = grid.log_chances(levels)
    yes, no = np.exp(log_yes), np.exp(log_no)
    cost = yes * np.where(yes > 0, log_yes, 0.0) + no * np.where(no > 0, log_no, 0.0)
    for array in (yes, cost):
        array.setflags(write=False)
    return Table(yes, cost)
