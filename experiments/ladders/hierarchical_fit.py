"""The likelihood of a hierarchical model: Laplace's approximation and quadrature over the participants."""

from functools import partial

import numpy as np

from tactometry.analysis.hierarchical.model import mixed_model
from tactometry.analysis.hierarchical.study import StudyCounts
from tactometry.analysis.mixed_models.laplace import ClusteredModel, inner_mode, log_marginal_by_quadrature
from tactometry.psychometric import shape_named

from ..cost.problem import Problem, Reference, Rung

LEVELS = np.array([-6.0, -3.0, 0.0, 3.0, 6.0])
N_YES = np.array([[0, 4, 8, 8, 8], [0, 2, 6, 7, 8], [0, 1, 5, 8, 8], [0, 1, 4, 6, 7], [0, 0, 2, 7, 8], [0, 0, 1, 4, 7]])
N_TRIALS, LAPSE_RATE, SPREAD = 8, 0.02, 12.0
GROUP = (0.0, np.log(0.6), 0.15, 0.1, 0.3)
"""Mean threshold and log width, and the triangle of their scales, in ranges of the levels."""
N_NODES, N_FINEST, N_GRID, FARTHEST = (1, 3, 5, 9), 21, 81, 7.0


def problem() -> Problem:
    """Six participants with random thresholds and widths, yes or no; one node is Laplace's approximation."""
    model = _model()
    return Problem(
        "relative error of the likelihood of a group, 6 participants with 5 levels of 8 trials",
        reference=Reference("21 x 21 nodes", lambda: _log_likelihood(model, N_FINEST), 1e-6),
        independent=Reference("equidistant sum, the function written out", _on_a_grid, 1e-6),
        error=lambda found, reference: abs(float(np.expm1(found - reference))),
        rungs=tuple(
            Rung(f"{n} x {n} nodes{' (Laplace)' if n == 1 else ''}", partial(_log_likelihood, model, n))
            for n in N_NODES
        ),
    )


def _model() -> ClusteredModel:
    n, n_levels = N_YES.shape
    names = np.repeat([f"P{place}" for place in range(n)], n_levels)
    answers = np.tile(LEVELS, n), N_YES.ravel().astype(float), np.full(N_YES.size, float(N_TRIALS))
    known = {"shape": shape_named("logistic"), "guess_rate": 0.0, "lapse_rate": LAPSE_RATE}
    return mixed_model(StudyCounts.of(names, {"condition": np.zeros(N_YES.size)}, (), answers, None, **known))


def _log_likelihood(model: ClusteredModel, n_nodes: int) -> float:
    group = np.array(GROUP)
    return log_marginal_by_quadrature(model, group, inner_mode(model, group), n_nodes=n_nodes)[0]


def _on_a_grid() -> float:
    """The logistic function written out, each participant's likelihood summed over equidistant effects."""
    axis = np.linspace(-FARTHEST, FARTHEST, N_GRID)
    first, second = np.meshgrid(axis, axis)
    mean, log_width, sd, slope, rest = GROUP
    threshold, width = SPREAD * (mean + sd * first), SPREAD * np.exp(log_width + slope * first + rest * second)
    steep = 2 * np.log(19) * (LEVELS[:, None, None] - threshold) / width
    chance = (1 - LAPSE_RATE) / (1 + np.exp(-steep))
    n_yes = N_YES[:, :, None, None]
    likelihood = np.prod(chance**n_yes * (1 - chance) ** (N_TRIALS - n_yes), axis=1)
    weight = np.exp(-(first**2 + second**2) / 2) / (2 * np.pi) * (axis[1] - axis[0]) ** 2
    return float(np.log((likelihood * weight).sum(axis=(1, 2))).sum())
