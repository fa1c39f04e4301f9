"""Grid of psychometric functions that a Bayesian procedure weighs."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tactometry.arguments.require import distinct, expect, numbers, some
from tactometry.psychometric import shape_named

from .outcome_model import Array, p_log_p, size

EQUAL = 1e-13
"""Relative difference, to the largest distance, below which distances are equal."""
NARROWEST = 1e-100
"""Lower bound of widths. Division by smaller widths would overflow."""
BLOCK = 512
"""Number of combinations of the other parameters summed at a time. Their table fits into the cache of one core."""


@dataclass(frozen=True)
class ParameterGrid:
    """Model of yes and no by thresholds, widths, guess and lapse rates.

    Threshold and width are defined as in `tactometry.psychometric` (half of the unscaled function, and its 0.05 to 0.95
    points). For levels in decibels the shape ``gumbel`` is Weibull's function of the amplitude. The shape ``weibull``
    requires the amplitude itself, with widths in natural logarithms.

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
        _check("widths", self.widths, NARROWEST, math.inf)
        _check("guess_rates", self.guess_rates, -1e-300, 1)
        _check("lapse_rates", self.lapse_rates, -1e-300, 1)
        total = max(self.guess_rates) + max(self.lapse_rates)
        rates = f"guess and lapse rates that add up to {total:g}"
        expect(total < 1, "ParameterGrid.lapse_rates", rates, "less than 1")

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
        """Number of thresholds, and of combinations of the other parameters."""
        return size(self)

    @cached_property
    def rates(self) -> tuple[Array, Array]:
        """Guess and lapse rate of each pair, two of (n_pairs,)."""
        guess, lapse = np.meshgrid(self.guess_rates, self.lapse_rates, indexing="ij")
        return guess.ravel(), lapse.ravel()

    def distances(self, levels: Sequence[float]) -> Array:
        """Return level minus threshold, or the log of their ratio for ``weibull``."""
        x, t = np.ix_(np.asarray(levels, dtype=np.float64), np.asarray(self.thresholds, dtype=np.float64))
        if not shape_named(self.shape).on_log_levels:
            return np.asarray(x - t)
        expect((x >= 0).all(), "ParameterGrid", f"the level {x.min():g}", "levels from 0 on")
        with np.errstate(divide="ignore"):
            return np.asarray(np.log(x) - np.log(t))

    def log_likelihood_at(self, distances: Array, outcome: int) -> Array:
        """Return log P(outcome) at distances, (*distances, n_widths, n_rates)."""
        shape, (guess, lapse) = shape_named(self.shape), self.rates
        z = shape.z50 + distances[..., None] / np.asarray(self.widths) * shape.z_width
        log_s = (shape.log_cdf if outcome else shape.log_sf)(z)
        s, floor, span = np.exp(log_s), guess if outcome else lapse, 1 - guess - lapse
        with np.errstate(divide="ignore"):
            mixed = np.log(np.stack([s, np.ones_like(s)], axis=-1) @ np.stack([span, floor]))  # span * s + floor
        no_floor = floor == 0
        if no_floor.any():
            mixed[..., no_floor] = np.log1p(-guess - lapse)[no_floor] + log_s[..., None]
        return np.asarray(mixed, dtype=np.float64)

    def log_likelihood(self, level: float, outcome: int) -> Array:
        return self.log_likelihood_at(self.distances([level])[0], outcome).ravel()

    def certainty(self, distances: Array) -> Array:
        """Return the sum of p log p, (*distances, n_widths, n_rates)."""
        return np.asarray(sum(p_log_p(np.exp(self.log_likelihood_at(distances, answer))) for answer in (0, 1)))

    def likelihoods(self, levels: Sequence[float]) -> "MixtureLikelihoods":
        return MixtureLikelihoods(self, tuple(levels))


def _check(name: str, values: tuple[float, ...], low: float, high: float) -> None:
    numbers(f"ParameterGrid.{name}", values)
    some(f"ParameterGrid.{name}", values)
    for n, value in enumerate(values):
        where = "" if low == -math.inf else f" between {max(low, 0):g} and {high:g}"
        expect(low < value < high, f"ParameterGrid.{name}[{n}]", value, f"a finite number{where}")
    distinct(f"ParameterGrid.{name}", values, "each value once")


@dataclass(frozen=True, eq=False)
class MixtureLikelihoods:
    """Likelihoods of P(1) = g + (1 - g - l) S.

    Sums over guess and lapse rates are computed before the product with S.
    """

    grid: ParameterGrid
    levels: tuple[float, ...]

    @cached_property
    def sigmoid(self) -> Array:
        """Values of S, (n_levels, n_thresholds, n_widths)."""
        shape = shape_named(self.grid.shape)
        distances = self.grid.distances(self.levels)[..., None]
        return np.exp(shape.log_cdf(shape.z50 + distances / np.asarray(self.grid.widths) * shape.z_width))

    @cached_property
    def mixture(self) -> Array:
        """Factor of S, summand and 1 for each pair of rates, (3, n_pairs)."""
        guess, lapse = self.grid.rates
        return np.array([1 - guess - lapse, guess, np.ones_like(guess)])

    def moments(self, weights: Array) -> Array:
        """Sum weighted `mixture` over rates, (3, n_thresholds, n_widths)."""
        sums: Array = self.mixture @ weights.reshape(-1, self.mixture.shape[1]).T
        return sums.reshape(3, len(self.grid.thresholds), -1)

    def total(self, weights: Array) -> Array:
        slopes, floors, masses = self.moments(weights)
        yes = self.sigmoid.reshape(len(self.levels), -1) @ slopes.ravel() + floors.sum()
        return np.array([masses.sum() - yes, yes])  # weights need not sum to 1: they may be moments

    def joint(self, weights: Array) -> Array:
        slopes, floors, masses = self.moments(weights)
        yes = np.matmul(self.sigmoid.transpose(1, 0, 2), slopes[..., None])[..., 0].T + floors.sum(axis=1)
        return np.array([masses.sum(axis=1) - yes, yes])

    @cached_property
    def steps(self) -> Array | None:
        """Distances from highest to lowest level, or None for unequal steps.

        With equal steps a probability depends only on the distance. Blocks of neighbouring thresholds are then views
        of one table (n_levels + n_thresholds - 1, n_rest), which fits into the cache.
        """
        distances = self.grid.distances(self.levels)
        if not np.isfinite(distances).all():
            return None
        along = np.concatenate([distances[::-1, 0], distances[0, 1:]])
        n_levels, n_thresholds = distances.shape
        expected = along[np.arange(n_levels - 1, -1, -1)[:, None] + np.arange(n_thresholds)]
        are_equal = np.abs(distances - expected).max() <= EQUAL * (1 + np.abs(distances).max())
        return along if are_equal else None

    @cached_property
    def log_tables(self) -> tuple[Array, Array] | None:
        """Log probabilities of no and yes at `steps`, two of (n_steps, n_rest)."""
        if self.steps is None:
            return None
        no, yes = (self.grid.log_likelihood_at(self.steps, answer).reshape(len(self.steps), -1) for answer in (0, 1))
        return no, yes

    def log_likelihood(self, index: int, outcome: int) -> Array | None:
        if self.log_tables is None:
            return None
        first = len(self.levels) - 1 - index
        return self.log_tables[outcome][first : first + len(self.grid.thresholds)].ravel()

    @cached_property
    def costs(self) -> Array:
        """Sum of p log p over answers, (n_thresholds, n_levels, n_rest)."""
        if self.steps is None:
            distances = self.grid.distances(self.levels)
            return np.stack([self.grid.certainty(column).reshape(-1, self.grid.size[1]) for column in distances.T])
        # reversed, so that a window runs along the levels; the first window then belongs to the last threshold
        table = self.grid.certainty(self.steps[::-1]).reshape(len(self.steps), -1)
        windows = np.lib.stride_tricks.sliding_window_view(table, len(self.levels), axis=0)
        return windows.transpose(0, 2, 1)[::-1]

    def certainty(self, weights: Array) -> Array:
        by_threshold = weights.reshape(len(self.grid.thresholds), -1, 1)
        total = np.zeros(len(self.levels))
        for n in range(0, by_threshold.shape[1], BLOCK):
            of_block = np.matmul(self.costs[:, :, n : n + BLOCK], by_threshold[:, n : n + BLOCK])
            total += of_block[..., 0].sum(axis=0)
        return total
