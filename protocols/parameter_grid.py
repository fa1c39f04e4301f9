"""The grid of psychometric functions that a Bayesian procedure weighs."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tactometry.errors import InvalidParameter
from tactometry.protocols.outcome_model import p_log_p
from tactometry.psychometric import shape_named

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ParameterGrid:
    """All combinations of thresholds, widths, guess and lapse rates of one shape: an `OutcomeModel` of answers 0, 1.

    Threshold and width as in `tactometry.psychometric` (half of the unscaled function; its 0.05 to 0.95 points). In
    decibels the shape ``gumbel`` is Weibull's function of the amplitude; ``weibull`` takes the amplitude itself, with
    widths in natural logarithms.

    Raises
    ------
    InvalidParameter
        If a list is empty, holds a value twice, or a value that is not of its domain, or guess and lapse rates leave
        nothing between them.

    >>> ParameterGrid(thresholds=(10.0, 20.0), widths=(4.0, 8.0), lapse_rates=(0.0, 0.02, 0.04)).size
    (2, 6)
    """

    thresholds: tuple[float, ...]
    widths: tuple[float, ...]
    guess_rates: tuple[float, ...] = (0.5,)
    lapse_rates: tuple[float, ...] = (0.02,)
    shape: str = "gumbel"

    n_outcomes = 2

    def __post_init__(self) -> None:
        _check("thresholds", self.thresholds, 0 if shape_named(self.shape).on_log_levels else -math.inf, math.inf)
        _check("widths", self.widths, 0, math.inf)
        _check("guess_rates", self.guess_rates, -1e-300, 1)
        _check("lapse_rates", self.lapse_rates, -1e-300, 1)
        if max(self.guess_rates) + max(self.lapse_rates) >= 1:
            raise InvalidParameter(
                f"ParameterGrid.lapse_rates: found guess and lapse rates that add up to "
                f"{max(self.guess_rates) + max(self.lapse_rates):g}, expected less than 1"
            )

    @property
    def parameters(self) -> Mapping[str, tuple[float, ...]]:
        return {
            "threshold": self.thresholds,
            "width": self.widths,
            "guess_rate": self.guess_rates,
            "lapse_rate": self.lapse_rates,
        }

    @property
    def size(self) -> tuple[int, int]:
        """(n_thresholds, n_others)."""
        return len(self.thresholds), len(self.widths) * len(self.guess_rates) * len(self.lapse_rates)

    @cached_property
    def rates(self) -> tuple[Array, Array]:
        """Guess and lapse rate of each pair, two of (n_pairs,)."""
        guess, lapse = np.meshgrid(self.guess_rates, self.lapse_rates, indexing="ij")
        return guess.ravel(), lapse.ravel()

    def z(self, levels: Sequence[float]) -> Array:
        """Where the levels stand on the standard shape, (n_levels, n_thresholds, n_widths).

        Raises
        ------
        InvalidParameter
            If a level is below 0 and the shape is ``weibull``.
        """
        shape = shape_named(self.shape)
        x, t, w = np.ix_(np.asarray(levels, float), np.asarray(self.thresholds, float), np.asarray(self.widths, float))
        if shape.on_log_levels:
            if (x < 0).any():
                raise InvalidParameter(f"ParameterGrid: found the level {x.min():g}, expected levels from 0 on")
            with np.errstate(divide="ignore"):
                x, t = np.log(x), np.log(t)
        return np.asarray(shape.z50 + (x - t) / w * shape.z_width, dtype=np.float64)

    def log_chance(self, level: float, outcome: int) -> Array:
        """log P(outcome) at a level, (n_cells,): a sum of positive terms, or of logarithms where the floor is 0."""
        shape, (guess, lapse) = shape_named(self.shape), self.rates
        log_s = (shape.log_cdf if outcome else shape.log_sf)(self.z([level])[0])[:, :, None]
        floor, log_span = guess if outcome else lapse, np.log1p(-guess - lapse)
        with np.errstate(divide="ignore"):
            mixed = np.log(floor + (1 - guess - lapse) * np.exp(log_s))
        return np.asarray(np.where(floor > 0, mixed, log_span + log_s).ravel(), dtype=np.float64)

    def chances(self, levels: Sequence[float]) -> "MixtureChances":
        return MixtureChances(self, tuple(levels))


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
class MixtureChances:
    """P(1) = g + (1 - g - l) S: all sums over guess and lapse rates are taken before the product with S."""

    grid: ParameterGrid
    levels: tuple[float, ...]

    @cached_property
    def sigmoid(self) -> Array:
        """S, (n_thresholds, n_levels, n_widths)."""
        s = np.exp(shape_named(self.grid.shape).log_cdf(self.grid.z(self.levels)))
        return np.ascontiguousarray(s.transpose(1, 0, 2))

    def joint(self, weights: Array) -> Array:
        guess, lapse = self.grid.rates
        cells = weights.reshape(len(self.grid.thresholds), len(self.grid.widths), -1)
        by_rates = cells.sum(axis=1)
        yes = np.matmul(self.sigmoid, cells @ (1 - guess - lapse)[:, None])[..., 0] + (by_rates @ guess)[:, None]
        return np.stack([by_rates.sum(axis=1)[:, None] - yes, yes]).transpose(0, 2, 1)

    @cached_property
    def cost(self) -> Array:
        """Sum over answers of p log p, (n_levels, n_cells), made level by level to spare memory."""
        cost = np.empty((len(self.levels), math.prod(self.grid.size)))
        for n, level in enumerate(self.levels):
            cost[n] = sum(p_log_p(np.exp(self.grid.log_chance(level, answer))) for answer in (0, 1))
        return cost

    def prepare(self) -> None:
        _ = self.cost, self.sigmoid

    def certainty(self, weights: Array) -> Array:
        product: Array = self.cost @ weights
        return product
