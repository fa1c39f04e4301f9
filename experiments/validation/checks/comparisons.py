"""Checks of points of subjective equality and just noticeable differences."""

from functools import partial
from typing import Final

import numpy as np
import pandas as pd

from ...bias_study.comparisons import PEOPLE, Person, outcomes_of
from ..check import ESTIMATES, Check


def outcomes(person: Person, n_sets: int, rng: np.random.Generator) -> pd.DataFrame:
    """Simulate data sets, and fit them as `analyse` does."""
    return pd.concat(outcomes_of((person,), n_sets, rng), ignore_index=True)


CHECK: Final = Check(
    title="Comparisons",
    words="""\
Answers are "more" or "less" at seven levels from -6 to 6, with points of subjective equality from -1.5 to 1.5. A lapse
is either answer with equal probability. Rows differ in the standard deviation of the function, the trials at each level
and the lapse rate. Fits are those of `analyse`, with both asymptotes free.""",
    kind=ESTIMATES,
    keys=("sd", "n_trials", "lapse_rate", "quantity"),
    settings={
        f"sd {each.sd:g}, {each.n_trials} trials, lapses {each.lapse_rate:g}": partial(outcomes, each)
        for each in PEOPLE
    },
    n_sets=50,
    reasons={
        "difference": "a Bayesian interval is exact on average over the prior of the lapse rate, not at each rate: "
        "intervals that miss the true value lie mostly below it without lapses, and above it with many",
        "equality": "same reason as for the difference",
    },
    figure="comparisons",
)
