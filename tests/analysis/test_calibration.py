"""Tests of simulation-based calibration of fits."""

import numpy as np
import pytest
from numpy.polynomial import legendre
from scipy.interpolate import CubicSpline
from scipy.stats import kstest
from soak import SOAK

from tactometry.analysis.threshold import shared_grid
from tactometry.analysis.threshold.counts import normalise
from tactometry.analysis.threshold.likelihood import GUESS, LAPSE, LOG_WIDTH, THRESHOLD
from tactometry.analysis.threshold.log_posterior import LARGEST_RATE, LogPosterior, Prior, log_threshold, log_width
from tactometry.analysis.threshold.mode import find_mode
from tactometry.analysis.threshold.posterior import rate_rule
from tactometry.psychometric import SHAPES, PsychometricFunction

pytestmark = pytest.mark.slow

LEVELS = np.linspace(-0.5, 0.5, 7)
GAP = 1 / 6
RARE = 1e-4
N_SETS, N_TRIALS, RATE_NODES = 1000, 20, 24


def drawn(log_density, low, high, n, rng) -> np.ndarray:
    """Draw from a density on an interval by rejection."""
    found = np.empty(0)
    fine = log_density(np.linspace(low, high, 2001)).max()
    while len(found) < n:
        x = rng.uniform(low, high, 4 * n)
        found = np.append(found, x[np.log(rng.random(4 * n)) < log_density(x) - fine])
    return found[:n]


def from_the_prior(rng, n, *, free_guess) -> list[np.ndarray]:
    """Draw threshold, width, lapse rate and guess rate from the prior."""
    threshold = drawn(lambda m: log_threshold(m)[0], -1, 1, n, rng)
    width = drawn(lambda w: log_width(np.log(w), np.array(GAP))[0], GAP, 3, n, rng)
    lapse, guess = (drawn(lambda x: 9 * np.log1p(-x), 0, LARGEST_RATE, n, rng) for _ in range(2))
    return [threshold, width, lapse, guess if free_guess else np.full(n, 0.5)]


def equidistant_rank(nodes, masses, truth) -> float:
    integral = CubicSpline(nodes, masses).antiderivative()
    return float(integral(truth) / integral(nodes[-1]))


def legendre_rank(end, masses, weights, truth) -> float:
    """Integrate the polynomial through the density at Gauss-Legendre nodes."""
    points, order = 2 * rate_rule(len(weights))[0] - 1, np.arange(len(weights))
    density = legendre.legvander(points, len(weights) - 1) * (masses / weights)[:, None] * weights[:, None]
    integral = legendre.legint((2 * order + 1) / 2 * density.sum(axis=0), lbnd=-1)
    return float(legendre.legval(2 * min(truth / end, 1.0) - 1, integral) / legendre.legval(1.0, integral))


@pytest.mark.parametrize(
    ("shape", "free_guess", "n_sets"),
    [("normal", False, N_SETS), ("gumbel", False, N_SETS), pytest.param("logistic", True, N_SETS if SOAK else 60)],
)
def test_ranks_of_truths_from_the_prior_are_uniform(monkeypatch, shape, free_guess, n_sets) -> None:
    """Simulation-based calibration (Talts et al. 2018): Kolmogorov-Smirnov at 1e-4, whatever the status."""
    monkeypatch.setattr(shared_grid, "RATE_NODES", RATE_NODES if not free_guess else 14)
    monkeypatch.setattr(shared_grid, "STEP_SD", 0.3)
    rng = np.random.default_rng()
    truth = from_the_prior(rng, n_sets, free_guess=free_guess)
    chance = [
        PsychometricFunction(shape, m, w, guess, lapse).probability(LEVELS)
        for m, w, lapse, guess in zip(*truth, strict=True)
    ]
    k = rng.binomial(N_TRIALS, chance).astype(float)
    counts = normalise(np.broadcast_to(LEVELS, k.shape), k, np.full(k.shape, float(N_TRIALS)))
    none = np.zeros(n_sets)
    prior = Prior(counts.gap, None, None if free_guess else 0.5, none, none)
    posterior = LogPosterior(SHAPES[shape], counts, prior)
    grid = shared_grid.common_grid(posterior, find_mode(posterior))
    along = shared_grid.marginal_masses(posterior, grid)[0]
    ranks = {}
    for place in prior.free:
        nodes, true = grid.nodes[place], truth[place]
        if place in (LAPSE, GUESS):
            weights, end = rate_rule(len(nodes))[1], nodes[0] / rate_rule(len(nodes))[0][0]
            ranks[place] = [legendre_rank(end, mass, weights, t) for mass, t in zip(along[place], true, strict=True)]
        else:
            at = np.log(true) if place == LOG_WIDTH else true
            ranks[place] = [equidistant_rank(nodes, mass, t) for mass, t in zip(along[place], at, strict=True)]
    chances = {place: kstest(np.clip(rank, 0, 1), "uniform").pvalue for place, rank in ranks.items()}
    assert {place: p for place, p in chances.items() if p < RARE / len(chances)} == {}
    assert set(chances) >= {THRESHOLD, LOG_WIDTH, LAPSE}
