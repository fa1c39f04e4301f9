"""What a posterior says of a psychometric function: means, medians, central intervals, its evidence, and how much of it
lies beyond the levels; from masses on a grid of threshold and log width."""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from scipy.interpolate import CubicSpline

from tactometry.psychometric import Shape

from ..arrays import Array, Bools, Indices
from .counts import Counts
from .likelihood import GUESS, LAPSE, LOG_WIDTH, N_PARAMETERS, THRESHOLD
from .prior import Prior


@dataclass(frozen=True)
class Marginals:
    """Posterior means (n_sets, 4), with the width itself in place of its logarithm, and central intervals.

    `threshold` and `width` have the shape (n_sets, 2), `median` that of threshold and width too; all on the scale of
    `Counts.u`. `overdispersion` (n_sets,) is the posterior mean of eta, 0 for the binomial. `log_evidence` (n_sets,) is
    the logarithm of the likelihood's mean over the prior; `beyond` (n_sets, 2) the posterior's share of curves whose
    rise lies below, and above, all levels tested.
    """

    mean: Array
    median: Array
    threshold: Array
    width: Array
    overdispersion: Array
    log_evidence: Array
    beyond: Array

    @classmethod
    def empty(cls, n: int) -> "Marginals":
        median, threshold, width, beyond = (np.full((n, 2), np.nan) for _ in range(4))
        mean = np.full((n, N_PARAMETERS), np.nan)
        return cls(mean, median, threshold, width, np.zeros(n), np.full(n, np.nan), beyond)

    def put(self, places: Indices, other: "Marginals", which: Bools) -> None:
        """Write those of another into some places of this one."""
        for field in fields(self):
            getattr(self, field.name)[places] = getattr(other, field.name)[which]


def described(
    mean: Array,
    ends: list[tuple[Array, Array, Array]],
    eta: Array,
    log_evidence: Array,
    beyond: Array,
    interval: float,
) -> Marginals:
    """From densities of threshold and log width, each (n_sets, n_nodes) on equidistant nodes with their ends."""
    shares = np.array([(1 - interval) / 2, 0.5, (1 + interval) / 2])
    threshold, width = quantiles(*ends[0], shares), np.exp(quantiles(*ends[1], shares))
    median, both = np.stack([threshold[:, 1], width[:, 1]], axis=1), [0, 2]
    return Marginals(mean, median, threshold[:, both], width[:, both], eta, log_evidence, beyond)


def quantiles(density: Array, low: Array, high: Array, shares: Array) -> Array:
    """Quantiles (n_sets, n_shares) of densities (n_sets, n_nodes) on equidistant nodes from `low` to `high`,
    by the integral of their cubic splines."""
    n_nodes = density.shape[1]
    fine = np.linspace(0, n_nodes - 1, 40 * n_nodes)
    integral = CubicSpline(np.arange(n_nodes), density, axis=1).antiderivative()(fine)
    # A spline may dip below 0 between two nodes, and what is inverted below has to rise.
    cumulated = np.maximum.accumulate(integral, axis=1)
    places = np.array([np.interp(shares * row[-1], row, fine) for row in cumulated])
    return np.asarray(low[:, None] + (high - low)[:, None] * places / (n_nodes - 1))


def log_cell(prior: Prior, low: Array, high: Array, sizes: Sequence[int]) -> float:
    """The logarithm of the volume of a cell of the grid; the weights of a free rate sum to 2."""
    size = high - low
    steps = [size[place] / (n - 1) for place, n in zip((THRESHOLD, LOG_WIDTH), sizes, strict=True)]
    rates = [size[place] / 2 for place in prior.free if place in (LAPSE, GUESS)]
    return float(np.log([*steps, *rates]).sum())


def beyond_levels(shape: Shape, counts: Counts, axes: Sequence[Array]) -> Array:
    """The part of each cell (2, n_thresholds, n_widths) in which the curve's rise, from its 0.05 to its 0.95 point,
    ends below the lowest level, and in which it begins above the highest, of one data set."""
    used = counts.u[0, counts.n_trials[0] > 0]
    m, width = axes[THRESHOLD][:, None], np.exp(axes[LOG_WIDTH])
    down, up = shape.rise
    inside = np.stack([m + up * width - used.min(), used.max() - (m - down * width)])
    step = axes[THRESHOLD][1] - axes[THRESHOLD][0]
    # A cell through which the edge runs counts in part, so that the shares do not jump with the grid.
    return np.asarray(np.clip(0.5 - inside / step, 0, 1))
