"""Simulation-based calibration of posteriors.

If true values are drawn from the prior, their ranks in their posteriors are uniformly distributed.

Talts, Betancourt, Simpson, Vehtari and Gelman (2018), arXiv 1804.06788.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from tactometry.analysis.tasks.comparison import FIT
from tactometry.analysis.threshold.counts import count_arrays, normalise
from tactometry.analysis.threshold.log_posterior import (
    LARGEST_RATE,
    WIDEST,
    LogPosterior,
    Prior,
    log_rate,
    log_threshold,
    log_width,
)
from tactometry.analysis.threshold.mode import find_mode
from tactometry.analysis.threshold.shared_grid import batched_marginals
from tactometry.protocols import QuestPlus
from tactometry.protocols.batch.answers import criteria
from tactometry.protocols.batch.tracks import tracks
from tactometry.protocols.bayesian.parameter_grid import ParameterGrid
from tactometry.protocols.bayesian.weighing import normalised
from tactometry.psychometric import SHAPES, PsychometricFunction

from ..check import Simulate

Array = NDArray[np.float64]
LEVELS: Final = np.linspace(-0.5, 0.5, 7)
"""Levels in units of their range, as in the priors."""
SHARES: Final = np.arange(0.1, 0.95, 0.1)
"""Coverages of central intervals. With the median, their ends divide the posterior into twentieths."""
FINE: Final = 4001


@dataclass(frozen=True)
class FitModel:
    """Fit whose posterior is checked.

    The fields are its shape, guess rate (None: free), trials per level, catch trials, and further options.
    """

    shape: str
    guess_rate: float | None
    n_trials: int
    n_catch: int = 0
    options: Mapping[str, Any] = field(default_factory=lambda: {"scale_free_width": True})

    def prior(self, gap: Array, n_false_alarms: Array, n_catch: Array) -> Prior:
        return Prior(gap, None, self.guess_rate, n_false_alarms, n_catch, **self.options)


OF_COMPARISON: Final = {name: value for name, value in FIT.items() if name not in ("shape", "guess_rate")}
MODELS: Final[Mapping[str, FitModel]] = {
    "2AFC, Gumbel": FitModel("gumbel", 0.5, 20),
    "2AFC, normal": FitModel("normal", 0.5, 10),
    "yes/no, Gumbel, catch trials": FitModel("gumbel", None, 10, n_catch=20),
    "comparison": FitModel("normal", None, 20, options=OF_COMPARISON),
}


def of_fit(name: str, n_sets: int, rng: np.random.Generator) -> pd.DataFrame:
    """Return the ranks of threshold and width in a fit's posterior."""
    model = MODELS[name]
    truth = from_prior(model, n_sets, rng)
    chances = [PsychometricFunction(model.shape, *each).probability(LEVELS) for each in truth[:, [0, 1, 3, 2]]]
    n_yes = rng.binomial(model.n_trials, chances)
    n_false_alarms = rng.binomial(model.n_catch, truth[:, 3]).astype(float)
    counts = normalise(*count_arrays(LEVELS, n_yes, model.n_trials))
    n_catch = np.full(n_sets, float(model.n_catch))
    posterior = LogPosterior(SHAPES[model.shape], counts, model.prior(counts.gap, n_false_alarms, n_catch))
    mode = find_mode(posterior)
    result = [batched_marginals(posterior, mode, float(share)) for share in SHARES]
    own = {"threshold": [each.threshold for each in result], "width": [each.width for each in result]}
    ranks = {
        quantity: rank(truth[:, place], np.stack(quantiles, axis=-1), rng)
        for place, (quantity, quantiles) in enumerate(own.items())
    }
    return pd.concat([pd.DataFrame({"posterior": name, "quantity": key, "rank": each}) for key, each in ranks.items()])


def from_prior(model: FitModel, n: int, rng: np.random.Generator) -> Array:
    """Draw threshold, width, lapse rate and guess rate (n, 4) from the prior."""
    none = np.zeros(1)
    prior = model.prior(np.array([LEVELS[1] - LEVELS[0]]), none, none)
    narrowest = prior.narrowest
    threshold = inverse(lambda m: log_threshold(m)[0], (-1.0, 1.0), rng.random(n))
    log_w = inverse(
        lambda v: log_width(v, narrowest, scale_free=prior.scale_free_width)[0] + v,
        (float(np.log(narrowest[0])), float(np.log(WIDEST))),
        rng.random(n),
    )
    lapse, guess = (
        inverse(partial(_log_rate, beta=beta), (0.0, LARGEST_RATE), rng.random(n))
        for beta in (prior.lapse_beta, prior.guess_beta)
    )
    if prior.equal_asymptotes:
        guess = lapse
    elif model.guess_rate is not None:
        guess = np.full(n, model.guess_rate)
    return np.stack([threshold, np.exp(log_w), lapse, guess], axis=1)


def _log_rate(x: Array, beta: float) -> Array:
    return log_rate(x, np.zeros(1), np.zeros(1), beta)[0]


def inverse(log_density: Callable[[Array], Array], ends: tuple[float, float], uniform: Array) -> Array:
    """Draw from a density between two ends by inverting it at uniform numbers."""
    x = np.linspace(ends[0], ends[1], FINE)
    with np.errstate(divide="ignore"):
        density = np.exp(log_density(x))
    summed = np.concatenate([[0.0], np.cumsum((density[1:] + density[:-1]) / 2)])
    return np.asarray(np.interp(uniform * summed[-1], summed, x))


def rank(truth: Array, quantiles: Array, rng: np.random.Generator) -> Array:
    """Rank true values (n_sets,) among quantiles (n_sets, 3, n_shares).

    The rank is random within the twentieth of the posterior that contains the true value.
    """
    places = np.concatenate([quantiles[:, 0], quantiles[:, 1, :1], quantiles[:, 2]], axis=1)
    below = (np.sort(places, axis=1) < truth[:, None]).sum(axis=1)
    return np.asarray((below + rng.random(len(truth))) / (places.shape[1] + 1))


def of_quest_plus(name: str, n_sets: int, rng: np.random.Generator) -> pd.DataFrame:
    """Return ranks of the true threshold in QUEST+'s posterior after a track.

    The rank is random within the grid node that contains the true threshold.
    """
    guess_rate, n_trials = QUEST_PLUS[name]
    levels = tuple(np.arange(0.0, 41.0, 2.0).tolist())
    grid = ParameterGrid(levels, (4.0, 8.0, 16.0), (guess_rate,), (0.0, 0.02, 0.05))
    rule = QuestPlus(levels, grid, n_trials)
    cells = rng.integers(rule.prior_state.weights.size, size=n_sets)
    axes = [np.asarray(axis) for axis in grid.parameters.values()]
    places = np.unravel_index(cells, [len(axis) for axis in axes])
    threshold, width, _, lapse = (axis[place] for axis, place in zip(axes, places, strict=True))
    columns = (each[:, None] for each in (threshold, width, np.full(n_sets, guess_rate), lapse))
    made = tracks(rule, criteria(rng.random((n_sets, n_trials)), "gumbel", *columns))
    logs = np.tile(rule.prior_state.log_weights, (n_sets, 1))
    for at, answers in zip(made.levels.T, made.answers.T, strict=True):
        logs += rule.log_likelihoods(at, answers)
    marginal = normalised(logs)[1].reshape(n_sets, len(levels), -1).sum(axis=2)
    place = np.searchsorted(rule.thresholds, threshold)
    sets = np.arange(n_sets)
    below = np.cumsum(marginal, axis=1)[sets, place] - marginal[sets, place]
    ranks = below + rng.random(n_sets) * marginal[sets, place]
    return pd.DataFrame({"posterior": name, "quantity": "threshold", "rank": np.clip(ranks, 0.0, 1.0)})


QUEST_PLUS: Final[Mapping[str, tuple[float, int]]] = {
    "QUEST+, 2AFC, 60 trials": (0.5, 60),
    "QUEST+, yes/no, 30 trials": (0.03, 30),
}
TRIALS: Final = ", ".join(f"{each.n_trials} trials at each for {name}" for name, each in MODELS.items())
SETTINGS: Final[Mapping[str, Simulate]] = {
    **{name: partial(of_fit, name) for name in MODELS},
    **{name: partial(of_quest_plus, name) for name in QUEST_PLUS},
}
