"""A simulated study of a group, and the fit of all its participants at once."""

import numpy as np
import pandas as pd

from tactometry.analysis.hierarchical.fitting import HierarchicalFit, fit_hierarchical
from tactometry.psychometric import PsychometricFunction

LEVELS = np.linspace(5, 33, 7)
SD, LOG_WIDTH_SD, CELL_SD, WIDTH, LAPSE_RATE = 2.5, 0.2, 0.8, 8.0, 0.02
RARE = 1e-4


def simulated(rng, *, n=8, means=None, n_trials=20, guess_rate=0.5) -> tuple[pd.DataFrame, dict]:
    """Counts of participants in conditions (forces), and the true thresholds of the cells."""
    means, rows, truth = means or {0.5: 18.0, 1.0: 19.0}, [], {}
    for p in range(n):
        own, width = SD * rng.normal(), WIDTH * np.exp(LOG_WIDTH_SD * rng.normal())
        for force_n, mean in means.items():
            threshold = truth[f"P{p}", force_n] = mean + own + CELL_SD * rng.normal()
            curve = PsychometricFunction("normal", threshold, width, guess_rate, LAPSE_RATE)
            k = rng.binomial(n_trials, curve.probability(LEVELS))
            rows += [(f"P{p}", force_n, x, each, n_trials) for x, each in zip(LEVELS, k, strict=True)]
    return pd.DataFrame(rows, columns=["participant", "force_n", "level", "k", "n"]), truth


def fitted(rows: pd.DataFrame, **options) -> HierarchicalFit:
    chosen = {"shape": "normal", "guess_rate": 0.5} | options
    return fit_hierarchical(
        rows["level"], rows["k"], rows["n"], rows["participant"], {"force_n": rows["force_n"]}, **chosen
    )
