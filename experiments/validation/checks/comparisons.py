"""Checks of points of subjective equality and just noticeable differences."""

from collections.abc import Mapping
from functools import partial
from typing import Final

import numpy as np
import pandas as pd

from ...bias_study.comparisons import PEOPLE, Person, outcomes_of
from ..check import Simulate


def outcomes(person: Person, n_sets: int, rng: np.random.Generator) -> pd.DataFrame:
    """Simulate data sets, and fit them as `analyse` does."""
    return pd.concat(outcomes_of((person,), n_sets, rng), ignore_index=True)


SETTINGS: Final[Mapping[str, Simulate]] = {
    f"sd {each.sd:g}, {each.n_trials} trials, lapses {each.lapse_rate:g}": partial(outcomes, each) for each in PEOPLE
}
