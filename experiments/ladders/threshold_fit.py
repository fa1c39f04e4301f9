"""The interval of one threshold, against the integral of the posterior written out."""

from typing import Any

import numpy as np
from scipy.special import ndtr, ndtri

from tactometry.analysis.threshold.fitting import ThresholdFit, fit, fit_many

from ..cost.problem import Problem, Real, Reference, Rung, over_interval

LEVELS = np.array([-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0])
N_CORRECT, N_TRIALS = np.array([23, 20, 26, 30, 37, 39, 40]), 40
N_SETS, RANGE, GAP = 16, 6.0, 1.0
N_FINEST, N_COARSER = (281, 241, 24), (201, 161, 16)
SHAPE: Any = {"shape": "normal", "guess_rate": 0.5}


def problem() -> Problem:
    """Two-alternative answers at seven levels; the shared grid takes its time for 16 sets at once."""
    return Problem(
        "largest error of mean and 95 % interval of the threshold over its width, 7 levels x 40 trials, 2AFC",
        reference=Reference("the posterior written out, integrated finely", lambda: posterior(*N_FINEST), 1e-5),
        independent=Reference("the same with fewer nodes", lambda: posterior(*N_COARSER), 1e-4),
        error=over_interval,
        rungs=(
            Rung(f"shared grid, {N_SETS} sets", _shared_interval),
            Rung("own grid", _own_interval),
        ),
    )


def _own_interval() -> Real:
    return estimate_and_ends(fit(LEVELS, N_CORRECT, N_TRIALS, estimate="mean", **SHAPE))


def _shared_interval() -> Real:
    """Of many sets on the same levels."""
    moved = np.minimum(N_CORRECT + np.arange(N_SETS)[:, None] % 2, N_TRIALS)
    return estimate_and_ends(fit_many(LEVELS, moved, N_TRIALS, estimate="mean", **SHAPE)[0])


def estimate_and_ends(fitted: ThresholdFit) -> Real:
    return np.array([fitted.threshold, fitted.interval_low, fitted.interval_high], dtype=np.float64)


def posterior(n_thresholds: int, n_widths: int, n_lapses: int) -> Real:
    """Mean and interval by equidistant and Gauss's nodes, the likelihood and psignifit's priors written out."""
    node, weight = np.polynomial.legendre.leggauss(n_lapses)
    thresholds = (np.arange(n_thresholds) + 0.5) / n_thresholds * 2 * RANGE - RANGE
    widths = GAP + (np.arange(n_widths) + 0.5) / n_widths * (3 * RANGE - GAP)
    lapses = (node + 1) / 4
    spread = 2 * ndtri(0.95)
    rise = ndtr((LEVELS[:, None, None] - thresholds[:, None]) / widths * spread)
    density = np.zeros((n_thresholds, n_widths, n_lapses))
    for share, k in zip(rise, N_CORRECT, strict=True):
        chance = 0.5 + (0.5 - lapses) * share[..., None]
        density += k * np.log(chance) + (N_TRIALS - k) * np.log1p(-chance)
    mass = np.exp(density - density.max()) @ (weight * (1 - lapses) ** 9)
    along = mass @ width_prior(widths, GAP, RANGE) * threshold_prior(thresholds, RANGE)
    return _summary(thresholds, along / along.sum())


def _summary(at: Real, mass: Real) -> Real:
    from scipy.interpolate import CubicSpline

    fine = np.linspace(at[0], at[-1], 100 * len(at))
    below = CubicSpline(at, mass).antiderivative()(fine)
    low, high = np.interp([0.025, 0.975], below / below[-1], fine)
    return np.array([mass @ at, low, high])


def threshold_prior(threshold: Real, level_range: float) -> Real:
    """Flat on the levels about 0, falling as a cosine over half their range beside."""
    outside = np.clip(np.abs(threshold) / level_range - 0.5, 0, 0.5)
    return np.asarray((1 + np.cos(2 * np.pi * outside)) / 2)


def width_prior(width: Real, spacing: float, level_range: float) -> Real:
    """Flat from twice the levels' spacing to their range, falling as a cosine to 0 at once and at three ranges."""
    narrow = np.clip((2 * spacing - width) / spacing, 0, 1)
    wide = np.clip((width - level_range) / (2 * level_range), 0, 1)
    return np.asarray((1 + np.cos(np.pi * np.maximum(narrow, wide))) / 2)
