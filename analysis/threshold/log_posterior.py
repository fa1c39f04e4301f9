"""Log posterior: the likelihood of the answers times the prior."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from tactometry.psychometric import Shape

from ..arrays import Array, Expansion, Indices, Rows
from . import likelihood
from .counts import Counts
from .likelihood import BINOMIAL_BELOW, GUESS, LAPSE, LOG_WIDTH, N_PARAMETERS, THRESHOLD
from .prior import Prior


@dataclass(frozen=True)
class LogPosterior(Rows):
    """Log posterior of data sets side by side, at parameters theta (n_sets, 4), without a constant."""

    shape: Shape
    counts: Counts
    prior: Prior

    def __len__(self) -> int:
        return len(self.counts)

    def under(self, **prior: Any) -> Self:
        """Return the log posterior with another prior."""
        return replace(self, prior=replace(self.prior, **prior))

    def redrawn(self, sets: Indices, n_yes: Array, n_false_alarms: Array) -> Self:
        """Return `sets` with other answers to trials and catch trials."""
        counts = replace(self.counts[sets], n_yes=n_yes)
        return replace(self, counts=counts, prior=replace(self.prior[sets], n_false_alarms=n_false_alarms))

    def alike(self) -> list[Indices]:
        """Group data sets on the same levels with the same catch trials; return their places by group."""
        counts, prior = self.counts, self.prior
        catch = np.stack([prior.n_false_alarms, prior.n_catch], axis=1)  # the prior of a free guess rate holds them
        rows = np.hstack([counts.u, counts.n_trials > 0, catch])
        if not len(rows) or (rows == rows[0]).all():
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
        """Return the log density with derivatives; those along fixed parameters are 0."""
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
            whole = self._answers(theta) + self.prior.expansion(theta)
        gradient, hessian = whole.gradient, whole.hessian
        if self.prior.equal_asymptotes:  # the guess rate moves with the lapse rate
            gradient[:, LAPSE] += gradient[:, GUESS]
            hessian[:, LAPSE] += hessian[:, GUESS]
            hessian[:, :, LAPSE] += hessian[:, :, GUESS]
        gradient[:, [place for place in range(N_PARAMETERS) if place not in self.prior.free]] = 0.0
        return whole

    def _answers(self, theta: Array) -> Expansion:
        binomial, eta = likelihood.expansion(self.shape, self.counts, theta), self.prior.overdispersion
        if eta is None or not (eta > 0).any():
            return binomial
        finite = np.maximum(eta, BINOMIAL_BELOW)  # 1 / eta^2 is finite, also where it is not taken
        spread = likelihood.overdispersed_expansion(self.shape, self.counts, theta, finite)
        return spread.where(eta >= BINOMIAL_BELOW, binomial)

    def _levels_of_one(self) -> Array:
        return np.asarray(self.counts.u[0, self.counts.n_trials[0] > 0])

    def z_of(self, axes: Sequence[Array]) -> Array:
        """Return z (n_levels, n_thresholds, n_widths) at the levels of one data set."""
        away = self._levels_of_one()[:, None, None] - axes[THRESHOLD][:, None]
        slope = self.shape.z_width * np.exp(-axes[LOG_WIDTH])
        return np.asarray(self.shape.z50 + away * slope)

    def beyond_levels(self, axes: Sequence[Array]) -> Array:
        """Return the part of each cell (2, n_thresholds, n_widths) with its whole rise below, or above, the levels."""
        used = self._levels_of_one()
        m, width = axes[THRESHOLD][:, None], np.exp(axes[LOG_WIDTH])
        down, up = self.shape.rise
        below, above = m + up * width - used.min(), used.max() - (m - down * width)
        inside = np.stack([below, above])
        step = np.gradient(axes[THRESHOLD])[:, None]
        # A cell through which the edge runs counts in part, so that the shares do not jump with the grid.
        return np.asarray(np.clip(0.5 - inside / step, 0, 1))
