"""The interval of a threshold by the bootstrap, against all answers that it might have drawn."""

from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import comb, ndtr, ndtri

from tactometry.analysis.threshold.fitting import fit_many

from ..cost.problem import Problem, Real, Reference, Rung
from .threshold_fit import threshold_prior, width_prior

LEVELS, N_YES, N_TRIALS, RATE = np.array([-1.0, 0.0, 1.0]), np.array([3, 6, 10]), 12, 0.02
GAP, RANGE, SPREAD = 1.0, 2.0, 2 * ndtri(0.95)
N_RESAMPLES, N_INTERVALS, INTERVAL = (50, 200, 800, 3200), 30, 0.95
THRESHOLDS, LOG_WIDTHS = np.linspace(-2.0, 2.0, 101)[1:-1], np.linspace(0.0, np.log(6.0), 241)[1:-1]


def problem() -> Problem:
    """Yes or no at three levels, 12 trials each: 2197 answers are possible, and each has its chance."""
    return Problem(
        f"rms error of the ends of the bootstrap's interval over its width, {N_INTERVALS} intervals, by resamples",
        reference=Reference("every possible answer with its chance, fitted", lambda: _interval(_fitted_modes()), 1e-3),
        independent=Reference(
            "the same with modes on a grid of the posterior, written out", lambda: _interval(_grid_modes()), 1e-2
        ),
        error=lambda found, reference: float(np.sqrt(np.mean((found - reference) ** 2)) / np.ptp(reference)),
        rungs=tuple(Rung(f"{n} resamples", partial(_bootstrap_intervals, n)) for n in N_RESAMPLES),
    )


def _bootstrap_intervals(n_resamples: int) -> Real:
    """(n_intervals, 2): of the same answers."""
    rates: Any = {"guess_rate": RATE, "lapse_rate": RATE, "rng": np.random.default_rng(0), "n_resamples": n_resamples}
    same = np.tile(N_YES, (N_INTERVALS, 1))
    fits = fit_many(LEVELS, same, N_TRIALS, shape="normal", method="bootstrap", interval=INTERVAL, **rates)
    return np.array([[fit.interval_low, fit.interval_high] for fit in fits], dtype=np.float64)


def _answers() -> NDArray[np.int64]:
    """(n_answers, n_levels): all counts of yes."""
    return np.stack(np.meshgrid(*[np.arange(N_TRIALS + 1)] * len(LEVELS), indexing="ij"), axis=-1).reshape(-1, 3)


def _chances(threshold: Real, log_width: Real) -> Real:
    """(..., n_levels) of yes."""
    rise = ndtr(SPREAD * (LEVELS - threshold[..., None]) / np.exp(log_width)[..., None])
    return np.asarray(RATE + (1 - 2 * RATE) * rise)


def _fitted_modes() -> tuple[Real, Real]:
    """Threshold and logarithm of the width of every answer, by the fit's own steps."""
    from tactometry.analysis.threshold.counts import count_arrays, normalise
    from tactometry.analysis.threshold.likelihood import LOG_WIDTH, THRESHOLD
    from tactometry.analysis.threshold.log_posterior import LogPosterior
    from tactometry.analysis.threshold.mode import find_mode
    from tactometry.analysis.threshold.prior import Prior
    from tactometry.psychometric import shape_named

    counts = normalise(*count_arrays(LEVELS, _answers(), N_TRIALS))
    none = np.zeros(len(counts))
    prior = Prior(counts.gap, RATE, RATE, none, none)
    theta = find_mode(LogPosterior(shape_named("normal"), counts, prior)).theta
    return theta[:, THRESHOLD] * RANGE, theta[:, LOG_WIDTH] + np.log(RANGE)


def _grid_modes() -> tuple[Real, Real]:
    """The same where the posterior is highest on a grid, by a parabola along the threshold."""
    answers, width = _answers(), np.exp(LOG_WIDTHS)
    profile, widest = np.empty((2, len(THRESHOLDS), len(answers)))
    for n, threshold in enumerate(THRESHOLDS):
        chance = _chances(np.asarray(threshold), LOG_WIDTHS)
        prior = np.log(threshold_prior(threshold, RANGE) * width_prior(width, GAP, RANGE))
        density = answers @ np.log(chance).T + (N_TRIALS - answers) @ np.log1p(-chance).T + prior
        profile[n], widest[n] = density.max(axis=1), LOG_WIDTHS[density.argmax(axis=1)]
    at, answer = np.clip(profile.argmax(axis=0), 1, len(THRESHOLDS) - 2), np.arange(len(answers))
    before, top, after = (profile[at + k, answer] for k in (-1, 0, 1))
    away = (before - after) / (2 * (before - 2 * top + after))
    return THRESHOLDS[at] + away * (THRESHOLDS[1] - THRESHOLDS[0]), widest[at, answer]


def _interval(modes: tuple[Real, Real]) -> Real:
    """Bias-corrected percentiles of the thresholds, each with the chance of its answer."""
    answers, (threshold, log_width) = _answers(), modes
    seen = int(np.flatnonzero((answers == N_YES).all(axis=1))[0])
    chance = _chances(threshold[seen], log_width[seen])
    weight = (comb(N_TRIALS, answers) * chance**answers * (1 - chance) ** (N_TRIALS - answers)).prod(axis=1)
    below = weight[threshold < threshold[seen]].sum() + 0.5 * weight[seen]
    order = np.argsort(threshold)
    ends = ndtr(2 * ndtri(below) + ndtri((1 + INTERVAL * np.array([-1.0, 1.0])) / 2))
    return np.asarray(threshold[order][np.searchsorted(weight[order].cumsum(), ends)])
