"""Very many simulated tracks with a fit each, batch by batch, in bounded memory: what a study of procedures or of power
asks for a million times."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactometry.analysis.threshold.track_modes import TrackModes, fit_modes
from tactometry.protocols.batch.answers import LevelTable, criteria
from tactometry.protocols.batch.tracks import tracks
from tactometry.protocols.order import stream
from tactometry.protocols.procedures.procedure import Rule
from tactometry.protocols.procedures.stepping import SteppingRule

BATCH = 2000
"""Tracks at a time: about 25 MB."""


@dataclass(frozen=True)
class Respondents:
    """Who answers: thresholds are normal about a mean, all else is alike. In the unit of what is felt."""

    threshold: float
    threshold_sd: float
    width: float
    guess_rate: float
    lapse_rate: float
    shape: str = "gumbel"


@dataclass(frozen=True, eq=False)
class FittedTracks:
    """True thresholds (n_sets,), how each track ended (codes of `protocols.procedures.stepping`), and its fit."""

    thresholds: NDArray[np.float64]
    endings: NDArray[np.int8]
    modes: TrackModes


def fitted_tracks(
    rule: Rule[Any],
    respondents: Respondents,
    batches: Iterable[int],
    seed: int,
    *,
    n_trials: int,
    table: LevelTable | None = None,
    size: int = BATCH,
) -> Iterator[FittedTracks]:
    """`size` tracks for each number of a batch, whose random numbers are its own: any batch can be made alone, by any
    process, in any order. With a `table` the levels of the stimulus are felt as it says, and are fitted as they are.

    >>> from tactometry.protocols import Staircase
    >>> people = Respondents(20.0, 3.0, 8.0, guess_rate=0.5, lapse_rate=0.02)
    >>> rule = Staircase(36.0, (8.0, 4.0, 2.0), 0.0, 40.0, n_trials=60, n_reversals=60)
    >>> one, two = fitted_tracks(rule, people, (0, 1), 1, n_trials=60)
    >>> (again,) = fitted_tracks(rule, people, (1,), 1, n_trials=60)
    >>> bool((two.modes.thresholds == again.modes.thresholds).all()), bool((one.thresholds == two.thresholds).any())
    (True, False)
    """
    shape, guess_rate, lapse_rate = respondents.shape, respondents.guess_rate, respondents.lapse_rate
    for number in batches:
        rng = stream(seed, number)
        thresholds = respondents.threshold + respondents.threshold_sd * rng.standard_normal(size)
        uniform = rng.random((size, n_trials))
        drawn = criteria(uniform, shape, thresholds[:, None], respondents.width, guess_rate, lapse_rate)
        orders = rule.orders(size, rng) if isinstance(rule, SteppingRule) else None
        made = tracks(rule, drawn, table, orders=orders)
        modes = fit_modes(made.levels, made.answers, shape=shape, guess_rate=guess_rate, lapse_rate=lapse_rate)
        yield FittedTracks(thresholds, made.endings, modes)
