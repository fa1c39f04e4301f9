"""How often was felt what: rates against the level, and over all levels."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from statsmodels.stats.proportion import proportion_confint

from ..arrays import Array

MAX_LEVELS = 16
"""More levels than this are drawn together for the rates."""


def detection_rates(counts: pd.DataFrame, factors: Sequence[str]) -> pd.DataFrame:
    """Rate of "yes", correct or "more" against the level in each condition, all participants together, from the
    table of counts.

    With Wilson's interval, which treats the answers as independent. Levels are drawn together into
    `MAX_LEVELS` classes of equal width, named by their mean, where there are more.
    """
    table = counts.drop(columns="participant")
    table["level"] = _classes(table["level"].to_numpy(dtype=float), table["n_trials"].to_numpy(dtype=float))
    rates = table.groupby([*factors, "task", "level"], sort=True, observed=True).sum().reset_index()
    low, high = proportion_confint(rates["n_yes"], rates["n_trials"], method="wilson")
    rate = rates["n_yes"] / rates["n_trials"]
    # Wilson's ends may miss a rate of exactly 0 or 1 by rounding, and a bar of an error has no negative length.
    return rates.assign(rate=rate, rate_low=np.minimum(low, rate), rate_high=np.maximum(high, rate))


def _classes(levels: Array, weights: Array) -> Array:
    if len(np.unique(levels)) <= MAX_LEVELS:
        return levels
    edges = np.linspace(levels.min(), levels.max(), MAX_LEVELS + 1)
    place = np.clip(np.digitize(levels, edges) - 1, 0, MAX_LEVELS - 1)
    total = np.bincount(place, weights, MAX_LEVELS)
    mean = np.bincount(place, weights * levels, MAX_LEVELS) / np.maximum(total, 1e-300)
    return np.asarray(mean[place])


def mean_rates(counts: pd.DataFrame, factors: Sequence[str]) -> pd.DataFrame:
    """Mean over participants of the rate over all levels, in each condition (the thesis's detection
    rates)."""
    keys = [*factors, "task"]
    sums = counts.groupby(["participant", *keys], observed=True)[["n_yes", "n_trials"]].sum().reset_index()
    rates = sums.assign(rate=sums["n_yes"] / sums["n_trials"])
    return rates.groupby(keys, sort=True, observed=True)["rate"].agg(rate="mean", sd="std", n="size").reset_index()
