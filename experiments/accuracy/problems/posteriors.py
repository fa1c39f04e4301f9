"""Accuracy problems of posterior distributions."""

from functools import partial
from typing import Any

import numpy as np
from scipy.special import ndtr, ndtri

from tactometry.analysis.hierarchical.model import GroupModel, StudyCounts
from tactometry.analysis.hierarchical.posterior import Conditional, Laplace, integrate
from tactometry.analysis.threshold.fitting import ThresholdFit, fit, fit_many
from tactometry.protocols import QuestPlus
from tactometry.protocols.bayesian.parameter_grid import ParameterGrid
from tactometry.psychometric import PsychometricFunction, shape_named

from ..measure import Problem, Real, Reference, Setting, over_interval

LEVELS = np.array([-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0])
N_CORRECT, N_TRIALS = np.array([23, 20, 26, 30, 37, 39, 40]), 40
N_SETS, RANGE, GAP, N_NODES = 16, 6.0, 1.0, (281, 241, 24)
SHAPE: Any = {"shape": "normal", "guess_rate": 0.5, "estimate": "mean"}
GROUP_LEVELS = np.array([-6.0, -3.0, 0.0, 3.0, 6.0])
N_YES = np.array([[0, 4, 8, 8, 8], [0, 2, 6, 7, 8], [0, 1, 5, 8, 8], [0, 1, 4, 6, 7], [0, 0, 2, 7, 8], [0, 0, 1, 4, 7]])
N_POINTS, N_FINEST = (16, 64, 256, 1024), 8192
LOW, HIGH, NARROW, WIDE = 0.0, 40.0, 4.0, 12.0
ANSWERS = ((30.0, 1), (20.0, 1), (14.0, 0), (18.0, 1), (16.0, 0), (18.0, 1), (17.0, 1), (15.0, 0), (19.0, 1), (16.0, 1))
N_THRESHOLDS = (6, 11, 21, 41, 81, 161)


def threshold_fit() -> Problem:
    """Fit thresholds to two-alternative answers at seven levels."""
    moved = np.minimum(N_CORRECT + np.arange(N_SETS)[:, None] % 2, N_TRIALS)
    return Problem(
        "largest error of mean and 95 % interval of the threshold over its width, 7 levels x 40 trials, 2AFC",
        reference=Reference("explicit posterior, integrated on a fine grid", _integrated_interval, 1e-6),
        error=over_interval,
        settings=(
            Setting(f"shared grid, {N_SETS} sets", lambda: _ends(fit_many(LEVELS, moved, N_TRIALS, **SHAPE)[0])),
            Setting("own grid", lambda: _ends(fit(LEVELS, N_CORRECT, N_TRIALS, **SHAPE))),
        ),
    )


def _ends(fitted: ThresholdFit) -> Real:
    return np.array([fitted.threshold, fitted.interval_low, fitted.interval_high], dtype=np.float64)


def _integrated_interval() -> Real:
    """Return the posterior mean and interval from a fine integration."""
    n_thresholds, n_widths, n_lapses = N_NODES
    node, weight = np.polynomial.legendre.leggauss(n_lapses)
    thresholds = (np.arange(n_thresholds) + 0.5) / n_thresholds * 2 * RANGE - RANGE
    widths = GAP + (np.arange(n_widths) + 0.5) / n_widths * (3 * RANGE - GAP)
    lapses, spread = (node + 1) / 4, 2 * ndtri(0.95)
    rise = ndtr((LEVELS[:, None, None] - thresholds[:, None]) / widths * spread)
    density = np.zeros(N_NODES)
    for share, k in zip(rise, N_CORRECT, strict=True):
        chance = 0.5 + (0.5 - lapses) * share[..., None]
        density += k * np.log(chance) + (N_TRIALS - k) * np.log1p(-chance)

    outside = np.clip(np.abs(thresholds) / RANGE - 0.5, 0, 0.5)
    narrow, wide = np.clip((2 * GAP - widths) / GAP, 0, 1), np.clip((widths - RANGE) / (2 * RANGE), 0, 1)
    threshold_prior = 1 + np.cos(2 * np.pi * outside)
    width_prior = 1 + np.cos(np.pi * np.maximum(narrow, wide))
    mass = np.exp(density - density.max()) @ (weight * (1 - lapses) ** 9) @ width_prior * threshold_prior
    return _summary(thresholds, mass / mass.sum())


def _summary(at: Real, mass: Real) -> Real:
    from scipy.interpolate import CubicSpline

    fine = np.linspace(at[0], at[-1], 100 * len(at))
    below = CubicSpline(at, mass).antiderivative()(fine)
    low, high = np.interp([0.025, 0.975], below / below[-1], fine)
    return np.array([mass @ at, low, high])


def hierarchical_fit() -> Problem:
    """Fit the hierarchical model to six participants."""
    n, n_levels = N_YES.shape
    names = np.repeat([f"P{place}" for place in range(n)], n_levels)
    answers = np.tile(GROUP_LEVELS, n), N_YES.ravel().astype(float), np.full(N_YES.size, 8.0)
    known: dict[str, Any] = {"shape": shape_named("logistic"), "guess_rate": 0.0, "lapse_rate": 0.02}
    model = GroupModel(StudyCounts.of(names, {"condition": np.zeros(N_YES.size)}, (), answers, **known))
    hyper, means = model.start(np.zeros(1), np.full(1, np.log(0.6)))
    laplace = Laplace(model, hyper, means)

    def spreads(n_points: int) -> Real:
        found = integrate(laplace, hyper, n_points)
        return _spreads(found.weights, found.at)

    return Problem(
        "relative error of standard errors and standard deviations (RMS), 6 participants with 5 levels of 8 trials",
        reference=Reference(f"{N_FINEST} points", lambda: spreads(N_FINEST), 3e-3),
        independent=Reference("equidistant sum over hyperparameters", lambda: _equidistant(laplace), 5e-3),
        error=lambda found, reference: float(np.sqrt(np.square(found / reference - 1).mean())),
        settings=tuple(Setting(f"{n} points", partial(spreads, n)) for n in N_POINTS),
    )


def _spreads(weights: Real, at: Conditional) -> Real:
    """Return the standard errors of mean and thresholds, and the model's SDs."""
    values = np.concatenate([at.means, at.cells[..., 0, 0]], axis=1)
    variances = np.concatenate([at.covariance[:, 0], at.variances[..., 0, 0]], axis=1)
    errors = np.sqrt(weights @ (variances + np.square(values - weights @ values)))
    return np.concatenate([errors, weights @ np.exp(at.hyper[:, :2])])


def _equidistant(laplace: Laplace) -> Real:
    """Integrate on an equidistant grid of SDs, correlation and width."""
    ends = ((-6.0, 0.5, 15), (-6.0, 0.8, 15), (-2.5, 2.5, 9), (-1.5, 0.8, 17))
    axes = [np.linspace(low, high, n) for low, high, n in ends]
    result = laplace(np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes)))
    weights = np.exp(result.log_density - result.log_density.max())
    return _spreads(weights / weights.sum(), result)


def quest_plus_grid() -> Problem:
    """Compute the QUEST+ threshold after ten two-alternative answers."""
    return Problem(
        "error of the posterior mean of the threshold after ten answers, over the range of 40 dB",
        reference=Reference("Gauss-Legendre integration, function by function", _integrated_mean, 1e-7),
        error=lambda found, reference: abs(found - reference) / (HIGH - LOW),
        settings=tuple(Setting(f"{n} x {n_widths(n)}", partial(_grid_mean, n)) for n in N_THRESHOLDS),
    )


def n_widths(n_thresholds: int) -> int:
    """Return the number of width values for a number of threshold values."""
    return min(n_thresholds // 2, 160)


def _grid_mean(n_thresholds: int) -> float:
    thresholds, widths = middles(LOW, HIGH, n_thresholds), middles(NARROW, WIDE, n_widths(n_thresholds))
    grid = ParameterGrid(thresholds, widths, shape="normal")
    procedure = QuestPlus((15.0, 20.0), grid, n_trials=len(ANSWERS) + 1).begin()
    for level, response in ANSWERS:
        procedure = procedure.after(response, delivered=level)
    return procedure.mean("threshold")


def middles(low: float, high: float, n: int) -> tuple[float, ...]:
    """Return the midpoints of n equal intervals."""
    return tuple((low + (high - low) * (np.arange(n) + 0.5) / n).tolist())


def _integrated_mean() -> float:
    node, weight = np.polynomial.legendre.leggauss(100)
    width_node, width_weight = np.polynomial.legendre.leggauss(20)
    thresholds, widths = LOW + (HIGH - LOW) * (node + 1) / 2, NARROW + (WIDE - NARROW) * (width_node + 1) / 2
    like = np.array([[_likelihood(t, w) for w in widths] for t in thresholds]) @ width_weight * weight
    return float(like @ thresholds / like.sum())


def _likelihood(threshold: float, width: float) -> float:
    function = PsychometricFunction("normal", float(threshold), float(width), 0.5, 0.02)
    return float(np.exp(sum(float(function.log_probability(level, response)) for level, response in ANSWERS)))
