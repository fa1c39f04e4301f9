"""The interval of the likelihood by Wald and by profile, against the profile written out."""

from functools import partial

import numpy as np
from scipy.special import ndtr, ndtri

from tactometry.analysis.threshold.fitting import fit

from ..cost.problem import Problem, Real, Rung, over_interval
from .threshold_fit import LEVELS, N_CORRECT, N_TRIALS, estimate_and_ends

GUESS, LAPSE = 0.5, 0.02
FALL = 1.9207294103470607
"""Half of the 95 % point of chi-square with one degree of freedom."""
LOG_WIDTHS, FARTHEST, GRID = (0.0, 3.5), 3.5, (801, 701)


def problem() -> Problem:
    """The answers of `threshold-fit`, with the lapse rate known."""
    return Problem(
        "largest error of threshold and 95 % interval of likelihood over its width, 7 levels x 40 trials, 2AFC",
        "the profile written out, by Brent's methods",
        "its highest values on a grid",
        reference=lambda: (_by_brent(), 1e-7),
        independent=lambda: (_on_a_grid(), 1e-4),
        error=over_interval,
        rungs=(Rung("Wald (ml)", partial(_fitted, "ml")), Rung("profile", partial(_fitted, "profile"))),
    )


def _fitted(method: str) -> Real:
    fitted = fit(LEVELS, N_CORRECT, N_TRIALS, shape="normal", guess_rate=GUESS, lapse_rate=LAPSE, method=method)
    return estimate_and_ends(fitted)


def _log_likelihood(threshold: Real, log_width: Real) -> Real:
    rise = ndtr((LEVELS - threshold[..., None]) / np.exp(log_width)[..., None] * 2 * ndtri(0.95))
    chance = GUESS + (1 - GUESS - LAPSE) * rise
    return np.asarray(np.log(chance) @ N_CORRECT + np.log1p(-chance) @ (N_TRIALS - N_CORRECT))


def _profile(threshold: float) -> float:
    from scipy.optimize import minimize_scalar

    at = np.asarray(threshold)
    lost = minimize_scalar(
        lambda w: -float(_log_likelihood(at, np.asarray(w))), bounds=LOG_WIDTHS, options={"xatol": 1e-10}
    )
    return -float(lost.fun)


def _by_brent() -> Real:
    from scipy.optimize import brentq, minimize_scalar

    best = minimize_scalar(lambda m: -_profile(m), bounds=(-FARTHEST, FARTHEST), options={"xatol": 1e-9})
    ends = [brentq(lambda m: _profile(m) + best.fun + FALL, best.x, far) for far in (-FARTHEST, FARTHEST)]
    return np.array([best.x, *ends])


def _on_a_grid() -> Real:
    from scipy.interpolate import CubicSpline

    thresholds, log_widths = np.linspace(-FARTHEST, FARTHEST, GRID[0]), np.linspace(*LOG_WIDTHS, GRID[1])
    profile = CubicSpline(thresholds, _log_likelihood(thresholds[:, None], log_widths).max(axis=1))
    fine = np.linspace(-FARTHEST, FARTHEST, 100 * GRID[0])
    inside = fine[profile(fine) > profile(fine).max() - FALL]
    return np.array([fine[profile(fine).argmax()], inside[0], inside[-1]])
