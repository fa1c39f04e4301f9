"""The integral over the variances of a hierarchical model: points of importance sampling."""

from functools import partial

import numpy as np

from tactometry.analysis.hierarchical.model import GroupModel, StudyCounts
from tactometry.analysis.hierarchical.posterior import Conditional, Laplace, integrate
from tactometry.psychometric import shape_named

from ..cost.problem import Problem, Real, Reference, Rung

LEVELS = np.array([-6.0, -3.0, 0.0, 3.0, 6.0])
N_YES = np.array([[0, 4, 8, 8, 8], [0, 2, 6, 7, 8], [0, 1, 5, 8, 8], [0, 1, 4, 6, 7], [0, 0, 2, 7, 8], [0, 0, 1, 4, 7]])
N_TRIALS, LAPSE_RATE = 8, 0.02
N_POINTS, N_FINEST = (16, 64, 256, 1024), 8192


def problem() -> Problem:
    """Return six participants with random thresholds and widths, yes or no."""
    model, hyper, means = _model()
    return Problem(
        "relative error of standard errors and standard deviations (RMS), 6 participants with 5 levels of 8 trials",
        reference=Reference(f"{N_FINEST} points", lambda: _spreads(model, hyper, means, N_FINEST), 3e-3),
        independent=Reference(
            "equidistant sum over the hyperparameters", partial(_on_a_grid, model, hyper, means), 5e-3
        ),
        error=lambda found, reference: float(np.sqrt(np.square(found / reference - 1).mean())),
        rungs=tuple(Rung(f"{n} points", partial(_spreads, model, hyper, means, n)) for n in N_POINTS),
    )


def _model() -> tuple[GroupModel, Real, Real]:
    n, n_levels = N_YES.shape
    names = np.repeat([f"P{place}" for place in range(n)], n_levels)
    answers = np.tile(LEVELS, n), N_YES.ravel().astype(float), np.full(N_YES.size, float(N_TRIALS))
    known = {"shape": shape_named("logistic"), "guess_rate": 0.0, "lapse_rate": LAPSE_RATE}
    model = GroupModel(StudyCounts.of(names, {"condition": np.zeros(N_YES.size)}, (), answers, None, **known))
    return model, *model.start(np.zeros(1), np.full(1, np.log(0.6)))


def _spreads(model: GroupModel, hyper: Real, means: Real, n_points: int) -> Real:
    found = integrate(Laplace(model, hyper, means), hyper, n_points)
    return _of_points(found.weights, found.at)


def _of_points(weights: Real, at: Conditional) -> Real:
    """Return standard errors of the mean and of the participants' thresholds, and both standard deviations."""
    values = np.concatenate([at.means, at.cells[..., 0, 0]], axis=1)
    variances = np.concatenate([at.covariance[:, 0], at.variances[..., 0, 0]], axis=1)
    errors = np.sqrt(weights @ (variances + np.square(values - weights @ values)))
    return np.concatenate([errors, weights @ np.exp(at.hyper[:, :2])])


def _on_a_grid(model: GroupModel, hyper: Real, means: Real) -> Real:
    """Sum over a grid of standard deviations, correlation and width, with no proposal."""
    ends = ((-6.0, 0.5, 15), (-6.0, 0.8, 15), (-2.5, 2.5, 9), (-1.5, 0.8, 17))
    axes = [np.linspace(low, high, n) for low, high, n in ends]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))
    found = Laplace(model, hyper, means)(points)
    weights = np.exp(found.log_density - found.log_density.max())
    return _of_points(weights / weights.sum(), found)
