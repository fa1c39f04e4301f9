"""The integral over the variances of a hierarchical model: points of importance sampling."""

from functools import partial

import numpy as np
from numpy.typing import NDArray

from tactometry.analysis.hierarchical.model import GroupModel
from tactometry.analysis.hierarchical.posterior import Laplace, integrate
from tactometry.analysis.hierarchical.study import StudyCounts
from tactometry.psychometric import shape_named

from ..cost.problem import Problem, Reference, Rung

LEVELS = np.array([-6.0, -3.0, 0.0, 3.0, 6.0])
N_YES = np.array([[0, 4, 8, 8, 8], [0, 2, 6, 7, 8], [0, 1, 5, 8, 8], [0, 1, 4, 6, 7], [0, 0, 2, 7, 8], [0, 0, 1, 4, 7]])
N_TRIALS, LAPSE_RATE = 8, 0.02
N_POINTS, N_FINEST = (32, 128, 256, 1024), 8192


def problem() -> Problem:
    """Return six participants with random thresholds and widths, yes or no."""
    model, hyper, means = _model()
    return Problem(
        "standard error of a group's mean threshold, relative, 6 participants with 5 levels of 8 trials",
        reference=Reference(f"{N_FINEST} points", lambda: _standard_error(model, hyper, means, N_FINEST), 2e-3),
        independent=Reference(
            "equidistant sum over the hyperparameters", partial(_on_a_grid, model, hyper, means), 2e-2
        ),
        error=lambda found, reference: abs(found / reference - 1),
        rungs=tuple(Rung(f"{n} points", partial(_standard_error, model, hyper, means, n)) for n in N_POINTS),
    )


def _model() -> tuple[GroupModel, NDArray[np.float64], NDArray[np.float64]]:
    n, n_levels = N_YES.shape
    names = np.repeat([f"P{place}" for place in range(n)], n_levels)
    answers = np.tile(LEVELS, n), N_YES.ravel().astype(float), np.full(N_YES.size, float(N_TRIALS))
    known = {"shape": shape_named("logistic"), "guess_rate": 0.0, "lapse_rate": LAPSE_RATE}
    model = GroupModel(StudyCounts.of(names, {"condition": np.zeros(N_YES.size)}, (), answers, None, **known))
    return model, *model.start(np.zeros(1), np.full(1, np.log(0.6)))


def _standard_error(model: GroupModel, hyper: NDArray[np.float64], means: NDArray[np.float64], n_points: int) -> float:
    found = integrate(Laplace(model, hyper, means), hyper, n_points)
    return _spread(found.weights, found.at.means[:, 0], found.at.covariance[:, 0, 0])


def _spread(weights: NDArray[np.float64], means: NDArray[np.float64], variances: NDArray[np.float64]) -> float:
    return float(np.sqrt(weights @ (variances + np.square(means - weights @ means))))


def _on_a_grid(model: GroupModel, hyper: NDArray[np.float64], means: NDArray[np.float64]) -> float:
    """Sum over a grid of standard deviations, correlation and width, with no proposal."""
    ends = ((-6.0, 0.5, 15), (-6.0, 0.8, 15), (-2.5, 2.5, 9), (-1.5, 0.8, 17))
    axes = [np.linspace(low, high, n) for low, high, n in ends]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))
    found = Laplace(model, hyper, means)(points)
    weights = np.exp(found.log_density - found.log_density.max())
    return _spread(weights / weights.sum(), found.means[:, 0], found.covariance[:, 0, 0])
