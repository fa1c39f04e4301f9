"""Log posterior with the priors of psignifit 4 (Schuett et al. 2016).

Priors are on the scale of `Counts.u`, with exact derivatives. The prior of the threshold is flat on the tested range
and decreases as a cosine to 0 half a range outside. That of the width is flat between twice the smallest spacing and
the range, and decreases as a cosine to 0 at the smallest spacing and at three times the range. Lapse rate and free
guess rate have the prior Beta(1, 10) on [0, 0.5]; equal asymptotes are a single rate. The probability of "yes" in a
catch trial is the guess rate.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from scipy.special import xlogy

from tactometry.psychometric import Shape

from ..arrays import Array, Expansion, Indices, Rows
from . import likelihood
from .counts import Counts
from .likelihood import BINOMIAL_BELOW, GUESS, LAPSE, LOG_WIDTH, N_PARAMETERS, THRESHOLD

BETA_B = 10.0
LARGEST_RATE = 0.5
WIDEST = 3.0
FURTHEST = 1.0
"""Largest absolute threshold u with a positive prior density."""
WIDTH_NODES = 400
NARROWEST = 0.05
"""Lower bound of a scale-free width, as a fraction of the range, as close levels within a track are not informative
about the width."""
LARGEST_ETA = 0.99
FLOOR = np.array([-np.inf, -np.inf, 1e-9, 1e-9])
"""Lower bounds of a grid search, as a probability may be 0 if a rate is exactly 0."""


@dataclass(frozen=True)
class Prior(Rows):
    """Priors of many data sets.

    `gap` (n_sets,) is the smallest spacing. A rate is free or fixed. Without `on_curve` the threshold and the width
    have no prior (maximum likelihood), but free rates do. With `scale_free_width` the flat part is flat in the log
    width. The priors of free rates are Beta(1, `lapse_beta`) and Beta(1, `guess_beta`). With `equal_asymptotes` both
    rates are one parameter, stored as the lapse rate. The smallest width is `narrowest_spacings` times the smallest
    spacing.
    """

    gap: Array
    lapse_rate: float | None
    guess_rate: float | None
    n_false_alarms: Array
    n_catch: Array
    on_curve: bool = True
    scale_free_width: bool = False
    overdispersion: Array | None = None
    lapse_beta: float = BETA_B
    guess_beta: float = BETA_B
    equal_asymptotes: bool = False
    narrowest_spacings: float = 1.0

    @property
    def narrowest(self) -> Array:
        """Smallest width (n_sets,)."""
        least = self.narrowest_spacings * self.gap
        return np.maximum(least, NARROWEST) if self.scale_free_width else least

    @property
    def free(self) -> list[int]:
        """Indices of the free parameters in a parameter vector."""
        rates = ((LAPSE, self.lapse_rate), (GUESS, 0.0 if self.equal_asymptotes else self.guess_rate))
        return [THRESHOLD, LOG_WIDTH, *(place for place, rate in rates if rate is None)]

    def tied(self, theta: Array) -> Array:
        """Return parameters (..., 4) with equal rates if asymptotes are equal."""
        if not self.equal_asymptotes:
            return theta
        return np.concatenate([theta[..., :GUESS], theta[..., [LAPSE]]], axis=-1)

    def guess_nodes(self, lapse: Array, guess: Array) -> Array:
        """Return guess rates that broadcast with lapse rates (n_lapse, 1)."""
        return lapse[:, None] if self.equal_asymptotes else guess

    def bounds(self) -> tuple[Array, Array]:
        """Return lower and upper bounds (n_sets, 4); 0 for a tied guess rate."""
        n = self.gap.shape[0]
        low, high = np.zeros((n, N_PARAMETERS)), np.full((n, N_PARAMETERS), LARGEST_RATE)
        reach = FURTHEST if self.on_curve else 20.0
        low[:, THRESHOLD], high[:, THRESHOLD] = -reach, reach
        low[:, LOG_WIDTH] = np.log(self.narrowest) - (0.0 if self.on_curve else 12.0)
        high[:, LOG_WIDTH] = np.log(WIDEST if self.on_curve else 1e4)
        for place, rate in ((LAPSE, self.lapse_rate), (GUESS, self.guess_rate)):
            if place not in self.free:
                low[:, place] = high[:, place] = rate or 0.0
        return low, high

    def log_density(self, theta: Array) -> Array:
        """Return the log density at theta (n_sets, ..., 4), up to a constant."""
        return _total(theta, self._by_parameter(np.moveaxis(theta, -1, 0)))

    def expansion(self, theta: Array) -> Expansion:
        """Return the log density with gradient and Hessian.

        The density is that on the axis on which the prior of the width is flat, so that its modes are modes of the
        likelihood.
        """
        by_parameter = self._by_parameter(np.moveaxis(theta, -1, 0))
        gradient, hessian = np.zeros(theta.shape), np.zeros((*theta.shape, N_PARAMETERS))
        for place, (_, first, second) in by_parameter.items():
            gradient[..., place], hessian[..., place, place] = first, second
        return Expansion(_total(theta, by_parameter), gradient, hessian)

    def along(self, axes: Sequence[Array]) -> list[Array]:
        """Return the log prior along four axes; 0 for fixed parameters."""
        known = self._by_parameter(axes, scale_free_width=self.scale_free_width)
        return [known[place][0] if place in known else np.zeros(len(axis)) for place, axis in enumerate(axes)]

    def search_axes(self, low: Array, high: Array, sizes: Sequence[int]) -> list[Array]:
        """Return coarse nodes along each parameter; one node if it is fixed."""
        first = np.maximum(low, FLOOR)
        nodes = [np.linspace(first[place], high[place], n) for place, n in enumerate(sizes)]
        return [axis if place in self.free else low[place, None] for place, axis in enumerate(nodes)]

    def log_cell(self, low: Array, high: Array, sizes: Sequence[int]) -> float:
        """Return the log volume of a grid cell (weights of rates sum to 2)."""
        size = high - low
        steps = [size[place] / (n - 1) for place, n in zip((THRESHOLD, LOG_WIDTH), sizes, strict=True)]
        rates = [size[place] / 2 for place in self.free if place in (LAPSE, GUESS)]
        return float(np.log([*steps, *rates]).sum())

    def _by_parameter(self, values: Array | Sequence[Array], *, scale_free_width: bool = False) -> "ByParameter":
        by_set = (-1, *[1] * (values[THRESHOLD].ndim - 1))
        by_parameter, none = {}, np.zeros(1)
        if self.lapse_rate is None:
            by_parameter[LAPSE] = log_rate(values[LAPSE], none, none, self.lapse_beta)
        if GUESS in self.free:
            alarms, catch = self.n_false_alarms.reshape(by_set), self.n_catch.reshape(by_set)
            by_parameter[GUESS] = log_rate(values[GUESS], alarms, catch - alarms, self.guess_beta)
        if self.on_curve:
            narrowest = self.narrowest.reshape(by_set)
            by_parameter[THRESHOLD] = log_threshold(values[THRESHOLD])
            by_parameter[LOG_WIDTH] = log_width(values[LOG_WIDTH], narrowest, scale_free=scale_free_width)
        return by_parameter

    def log_mass(self) -> Array:
        """Return the log integral (n_sets,) of the prior, without catch trials."""
        low = np.log(self.narrowest)[:, None]
        v = low + np.linspace(0, 1, WIDTH_NODES) * (np.log(WIDEST) - low)
        log_density_of_w, _, _ = log_width(v, self.narrowest[:, None], scale_free=self.scale_free_width)
        density = np.exp(log_density_of_w + v)  # dw = w dv
        # 1.5 is the integral of the threshold's prior: 1 inside, 1/4 on each side
        along = np.log(1.5 * np.trapezoid(density, v, axis=1))
        betas = {LAPSE: self.lapse_beta, GUESS: self.guess_beta}
        return np.asarray(along + sum(log_rate_mass(beta) for place, beta in betas.items() if place in self.free))


ByParameter = dict[int, tuple[Array, Array, Array]]


def _total(theta: Array, by_parameter: ByParameter) -> Array:
    return sum((log_density for log_density, _, _ in by_parameter.values()), np.zeros(theta.shape[:-1]))


def log_rate(x: Array, n_yes: Array, n_no: Array, beta: float) -> tuple[Array, Array, Array]:
    """Return the log density of Beta(1 + n_yes, beta + n_no) and derivatives."""
    b = beta - 1 + n_no
    value = b * np.log1p(-x) + xlogy(n_yes, np.maximum(x, 1e-300))
    inside = np.maximum(x, 1e-100)  # larger floor, as the square must not underflow
    first = -b / (1 - x) + n_yes / inside
    return value, first, -b / (1 - x) ** 2 - n_yes / inside**2


def log_rate_mass(beta: float) -> float:
    """Return the log of the integral of a rate's density."""
    return float(np.log((1 - (1 - LARGEST_RATE) ** beta) / beta))


def _log_cos2(angle: Array, rate: Array | float) -> tuple[Array, Array, Array]:
    """Return 2 log cos(angle) and derivatives; `rate` is d angle / d x."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        value = 2 * np.log(np.cos(np.minimum(angle, np.pi / 2)))
        cos = np.maximum(np.cos(angle), 1e-8)  # keeps derivatives finite at the end of the prior
    first = -2 * rate * np.sin(angle) / cos
    second = -2 * np.square(rate) / cos**2
    return np.where(angle < np.pi / 2, value, -np.inf), first, second


def log_threshold(m: Array) -> tuple[Array, Array, Array]:
    """Return the log prior of the threshold and its derivatives."""
    outside = np.maximum(np.abs(m) - 0.5, 0.0)
    value, first, second = _log_cos2(np.pi * outside, np.pi * np.sign(m))
    # The flat part has no curvature, unlike the top of a cosine.
    return value, first, np.where(outside > 0, second, 0.0)


def log_width(v: Array, gap: Array, *, scale_free: bool = False) -> tuple[Array, Array, Array]:
    """Return the log prior of w = exp(v), and its derivatives in v."""
    w = np.exp(v)
    wide, narrow = w >= 1, (w < 1) & (w < 2 * gap)
    above = np.maximum(w, 1) - 1
    at_wide = _log_cos2(np.pi / 4 * above, np.pi / 4)
    below = np.clip((2 * gap - w) / gap, 0, 2)
    at_narrow = _log_cos2(np.pi / 2 * below, -np.pi / (2 * gap))
    ends = zip(at_wide, at_narrow, strict=True)
    value, by_w, by_ww = (np.where(wide, at_top, np.where(narrow, at_foot, 0.0)) for at_top, at_foot in ends)
    slope = 1.0 if scale_free else 0.0  # flat in v means a density 1 / w of w, with logarithm -v
    return value - slope * v, by_w * w - slope, by_ww * w * w + by_w * w


def log_prior_of(eta: Array | float) -> Array:
    """Return the log density of Beta(1, 10) at eta, up to a constant."""
    return np.asarray((BETA_B - 1) * np.log1p(-eta))


@dataclass(frozen=True)
class LogPosterior(Rows):
    """Log posterior of many data sets, up to a constant."""

    shape: Shape
    counts: Counts
    prior: Prior

    def __len__(self) -> int:
        return len(self.counts)

    def under(self, **prior: Any) -> Self:
        """Return a copy with changed options of the prior."""
        return replace(self, prior=replace(self.prior, **prior))

    def redrawn(self, sets: Indices, n_yes: Array, n_false_alarms: Array) -> Self:
        """Return the data sets at indices `sets` with new answers."""
        counts, prior = replace(self.counts[sets], n_yes=n_yes), self.prior[sets]
        return replace(self, counts=counts, prior=replace(prior, n_false_alarms=n_false_alarms))

    def alike(self) -> list[Indices]:
        """Group the indices of data sets with equal levels and catch trials."""
        counts, prior = self.counts, self.prior
        catch = np.stack([prior.n_false_alarms, prior.n_catch], axis=1)  # they enter the prior of a free guess rate
        rows = np.hstack([counts.u, counts.n_trials > 0, catch])
        if (rows == rows[:1]).all():
            return [np.arange(len(rows))] if len(rows) else []
        group = np.unique(rows, axis=0, return_inverse=True)[1].ravel()
        order = np.argsort(group, kind="stable")
        return np.split(order, np.flatnonzero(np.diff(group[order])) + 1)

    def by_level(self) -> Self:
        return replace(self, counts=self.counts.by_level())

    def log_likelihood(self, theta: Array) -> Array:
        return likelihood.log_likelihood(self.shape, self.counts, theta)

    def deviance(self, theta: Array) -> Array:
        return 2 * (likelihood.saturated_log_likelihood(self.counts) - self.log_likelihood(theta))

    def log_density(self, theta: Array) -> Array:
        return self.log_likelihood(theta) + self.prior.log_density(theta)

    def expansion(self, theta: Array) -> Expansion:
        """Return the log density with derivatives; 0 for fixed parameters."""
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
            whole = self._answers(theta) + self.prior.expansion(theta)
        gradient, hessian = whole.gradient, whole.hessian
        if self.prior.equal_asymptotes:  # the guess rate equals the lapse rate
            gradient[:, LAPSE] += gradient[:, GUESS]
            hessian[:, LAPSE] += hessian[:, GUESS]
            hessian[:, :, LAPSE] += hessian[:, :, GUESS]
        gradient[:, [place for place in range(N_PARAMETERS) if place not in self.prior.free]] = 0.0
        return whole

    def _answers(self, theta: Array) -> Expansion:
        binomial, eta = likelihood.expansion(self.shape, self.counts, theta), self.prior.overdispersion
        if eta is None or not (eta > 0).any():
            return binomial
        finite = np.maximum(eta, BINOMIAL_BELOW)  # keeps 1 / eta^2 finite, even if the result is not used
        spread = likelihood.overdispersed_expansion(self.shape, self.counts, theta, finite)
        return spread.where(eta >= BINOMIAL_BELOW, binomial)

    def _levels_of_one(self) -> Array:
        return np.asarray(self.counts.u[0, self.counts.n_trials[0] > 0])

    def z_of(self, axes: Sequence[Array]) -> Array:
        """Return z of one data set (n_levels, n_thresholds, n_widths)."""
        away = self._levels_of_one()[:, None, None] - axes[THRESHOLD][:, None]
        slope = self.shape.z_width * np.exp(-axes[LOG_WIDTH])
        return np.asarray(self.shape.z50 + away * slope)

    def beyond_levels(self, axes: Sequence[Array]) -> Array:
        """Return the fractions of cells that rise below or above all levels.

        Their shape is (2, n_thresholds, n_widths).
        """
        used = self._levels_of_one()
        m, width = axes[THRESHOLD][:, None], np.exp(axes[LOG_WIDTH])
        down, up = self.shape.rise
        below, above = m + up * width - used.min(), used.max() - (m - down * width)
        inside = np.stack([below, above])
        step = np.gradient(axes[THRESHOLD])[:, None]
        # Cells on the edge count in part, so that fractions do not jump with the grid.
        return np.asarray(np.clip(0.5 - inside / step, 0, 1))
