"""Tests of the hierarchical posterior: points, mixtures and draws."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ndtr

from tactometry.analysis.hierarchical.model import GroupModel, StudyCounts, rate_of
from tactometry.analysis.hierarchical.posterior import Laplace, integrate, quantiles
from tactometry.analysis.hierarchical.tables import draw_cells
from tactometry.experiments.bias_study.groups import outcome
from tactometry.psychometric import SHAPES, PsychometricFunction

LEVELS, N_TRIALS = np.array([-6.0, -3.0, 0.0, 3.0, 6.0]), 8
N_YES = np.array([[0, 4, 8, 8, 8], [0, 2, 6, 7, 8], [0, 1, 5, 8, 8], [0, 1, 4, 6, 7], [0, 0, 2, 7, 8], [0, 0, 1, 4, 7]])


def model_of(n_yes, lapse_rate=0.02) -> GroupModel:
    n, n_levels = n_yes.shape
    names = np.repeat([f"P{place}" for place in range(n)], n_levels)
    answers = np.tile(LEVELS, n), n_yes.ravel().astype(float), np.full(n_yes.size, float(N_TRIALS))
    known = {"shape": SHAPES["logistic"], "guess_rate": 0.0, "lapse_rate": lapse_rate}
    return GroupModel(StudyCounts.of(names, {"condition": np.zeros(n_yes.size)}, (), answers, **known))


def test_quantiles_of_a_mixture_reach_their_share() -> None:
    weights, means, sds = np.array([0.2, 0.5, 0.3]), np.array([-3.0, 0.0, 4.0]), np.array([1.0, 0.5, 0.0])
    low = quantiles(weights, means, sds, 0.1)
    assert weights @ ndtr((low - means) / np.array([1.0, 0.5, 1e-9])) == pytest.approx(0.1, abs=1e-9)
    assert quantiles(weights, means, sds, 0.9) == pytest.approx(4.0, abs=1e-6)


def test_draws_of_participants_stay_near_laplace() -> None:
    model = model_of(N_YES[:2])
    hyper = np.array([np.log(0.2), np.log(0.3), 0.0, np.log(0.5)])
    found = integrate(Laplace(model, hyper, np.zeros(1)), hyper, 64)
    draws = draw_cells(model, found, 2**14)
    mean = (draws.weights[..., None] * draws.points[:, :, 0]).sum(axis=0)
    normal = found.mean(found.at.cells[:, :, 0])
    sds = np.sqrt(found.mean(found.at.variances[:, :, 0] + np.square(found.at.cells[:, :, 0] - normal)))
    assert (np.abs(mean - normal) < 0.4 * sds).all()
    assert (draws.n_effective > 2**12).all()


def test_log_likelihood_slopes_are_derivatives() -> None:
    model = model_of(N_YES[:2], lapse_rate=None)
    hyper = np.zeros((1, len(model.hyper)))
    at = np.array([0.05, -0.7, -3.0]) + np.zeros((1, 2, 1, 3))
    found = model.log_likelihood(at, hyper)
    for axis in range(3):
        step = 1e-5 * np.eye(3)[axis]
        ahead, behind = (model.log_likelihood(at + side * step, hyper) for side in (1, -1))
        assert found.gradient[..., axis] == pytest.approx((ahead.value - behind.value) / 2e-5, rel=1e-5, abs=1e-6)
        assert found.hessian[..., axis] == pytest.approx((ahead.gradient - behind.gradient) / 2e-5, rel=1e-4, abs=1e-5)


def test_information_is_the_curvature_at_expected_counts() -> None:
    """The log-likelihood is linear in the counts."""
    model = model_of(N_YES[:2], lapse_rate=None)
    hyper, at = np.zeros((1, len(model.hyper))), np.array([0.05, -0.7, -3.0]) + np.zeros((1, 2, 1, 3))
    lapse_rate = float(rate_of(np.array(-3.0))[0])
    curve = PsychometricFunction("logistic", 0.05, np.exp(-0.7), 0.0, lapse_rate)
    expected = N_TRIALS * curve.probability(model.study.u)
    at_expected = GroupModel(replace(model.study, n_yes=expected))
    curvature = -at_expected.log_likelihood(at, hyper).hessian
    assert model.information(at, hyper) == pytest.approx(curvature, rel=1e-9, abs=1e-9)


def test_bias_study_of_groups_is_repeatable() -> None:
    one, other = (outcome("1 up 3 down", "2 of 10 at 15 %", 3, 1) for _ in range(2))
    assert one == other
    assert 0.5 < one["participants"] <= 1
    assert abs(one["mean_db"]) < 10
