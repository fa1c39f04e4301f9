"""Checks of equality points and just noticeable differences."""

from functools import partial
from typing import Final

import numpy as np
import pandas as pd

from ...bias_study.comparisons import PEOPLE, Person, outcomes_of
from ..check import ESTIMATES, Check


def outcomes(person: Person, n_sets: int, rng: np.random.Generator) -> pd.DataFrame:
    """Fit data sets as `analyse` does."""
    return pd.concat(outcomes_of((person,), n_sets, rng), ignore_index=True)


CHECK: Final = Check(
    title="Comparisons",
    words="""\
Answers "more" or "less" at seven levels from -6 to 6, with points of subjective equality from -1.5 to 1.5; a lapse is
either answer with equal chance. Rows by the standard deviation of the function, trials at each level and lapse rate.
Fitted as `analyse` does: both asymptotes are free.""",
    kind=ESTIMATES,
    keys=("sd", "n_trials", "lapse_rate", "quantity"),
    settings={
        f"sd {each.sd:g}, {each.n_trials} trials, lapses {each.lapse_rate:g}": partial(outcomes, each)
        for each in PEOPLE
    },
    n_sets=50,
    reasons={
        "difference": "a Bayesian interval is exact on average over the prior of the lapse rate, not at each rate: "
        "misses are mostly below the truth without lapses, and above it with many",
        "equality": "as for the difference",
    },
    figure="comparisons",
)
