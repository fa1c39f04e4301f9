"""Points of subjective equality and just noticeable differences, by the spread of the function, trials and lapses."""

from functools import partial
from typing import Final

import numpy as np
import pandas as pd

from ...census.comparisons import PEOPLE, Person, census
from ..check import Check
from ..kinds import ESTIMATES

TITLES: Final = {"pse": "equality", "jnd": "difference"}


def outcomes(person: Person, n_sets: int, rng: np.random.Generator) -> pd.DataFrame:
    """Of data sets fitted as `analyse` fits them."""
    (table,) = census((person,), n_sets, rng)
    keys = ["sd", "n_trials", "lapse_rate"]
    parts = []
    for name, title in TITLES.items():
        columns = {f"true_{name}": "truth", name: "estimate", f"{name}_low": "low", f"{name}_high": "high"}
        parts.append(table[[*keys, *columns]].rename(columns=columns).assign(quantity=title))
    return pd.concat(parts, ignore_index=True)


CHECK: Final = Check(
    title="Comparisons",
    words="""\
Answers "more" or "less" at seven levels from -6 to 6, with points of subjective equality anywhere from -1.5 to 1.5;
a lapse is either answer with the same chance. Rows by the standard deviation of the function, trials at each level
and the share of trials without attention. Fitted as `analyse` does: both asymptotes are free.""",
    kind=ESTIMATES,
    keys=("quantity", "sd", "n_trials", "lapse_rate"),
    settings={
        f"sd {each.sd:g}, {each.n_trials} trials, lapses {each.lapse_rate:g}": partial(outcomes, each)
        for each in PEOPLE
    },
    n_sets=50,
    reasons={
        "difference": "a Bayesian interval is exact on average over the prior of the rate of lapses, not at each "
        "rate: without "
        "lapses most that miss lie below the truth, at many lapses above it",
        "equality": "as that of the difference",
    },
    reason_key="quantity",
    figure="comparisons",
)
