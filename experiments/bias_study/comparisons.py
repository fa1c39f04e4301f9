"""Coverage of points of subjective equality (PSEs) and of JNDs.

A lapse is "more" or "less" with equal probability. At a lapse rate of 5 %, the asymptotes are 0.025 and 0.975. PSEs lie
in the middle quarter of the levels.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
import pandas as pd
from scipy.special import ndtr
from scipy.stats import ttest_rel

from tactometry.analysis.tasks.comparison import FIT
from tactometry.analysis.tasks.task_analysis import JND_PER_SD, SHAPE
from tactometry.analysis.threshold.equality import fit_comparisons
from tactometry.analysis.threshold.estimates import ThresholdFit
from tactometry.observers.signal_detection import SignalDetectionObserver

LEVELS = tuple(np.linspace(-6.0, 6.0, 7).tolist())
SDS, N_TRIALS, LAPSE_RATES = (1.5, 2.5), (20, 40), (0.0, 0.02, 0.03, 0.05)
FARTHEST_PSE = 1.5
WITHOUT_LAPSES: Mapping[str, Any] = {"shape": SHAPE, "guess_rate": 0.0, "lapse_rate": 0.0}
QUANTITIES = {"pse": "equality", "jnd": "difference"}
FITTED = ("threshold", "interval_low", "interval_high", "jnd", "jnd_low", "jnd_high")


@dataclass(frozen=True)
class Person:
    """Simulated participant: spread, trials per level and lapse rate."""

    sd: float
    n_trials: int
    lapse_rate: float


PEOPLE = tuple(Person(*each) for each in product(SDS, N_TRIALS, LAPSE_RATES))


def answers(person: Person, n_sets: int, rng: np.random.Generator) -> tuple["np.ndarray", "np.ndarray"]:
    """Draw PSEs (n_sets,) and numbers of "more" (n_sets, n_levels)."""
    pse = rng.uniform(-FARTHEST_PSE, FARTHEST_PSE, n_sets)
    felt = ndtr((np.array(LEVELS) - pse[:, None]) / person.sd)
    return pse, rng.binomial(person.n_trials, person.lapse_rate / 2 + (1 - person.lapse_rate) * felt)


def outcomes_of(
    people: Sequence[Person], n_sets: int, rng: np.random.Generator, options: Mapping[str, Any] = FIT
) -> Iterator[pd.DataFrame]:
    """Yield true values, estimates and intervals by participant and quantity."""
    for person in people:
        pse, n_more = answers(person, n_sets, rng)
        fitted = fit_comparisons(LEVELS, n_more, person.n_trials, **options)
        result = np.array([[getattr(one, name) for name in FITTED] for one in fitted], dtype=float)
        truths = {"equality": pse, "difference": np.full(n_sets, JND_PER_SD * person.sd)}
        for place, (quantity, truth) in enumerate(truths.items()):
            table = pd.DataFrame(result[:, 3 * place : 3 * place + 3], columns=["estimate", "low", "high"])
            yield table.assign(truth=truth, quantity=quantity, **vars(person))


def summary(outcomes: pd.DataFrame) -> pd.DataFrame:
    """Return coverage by quantity and participant.

    An open or missing interval end covers all values on its side. `over_truth` is the median ratio of estimate to true
    value.
    """
    by = ["quantity", "sd", "n_trials", "lapse_rate"]
    above, below = outcomes["low"] > outcomes["truth"], outcomes["high"] < outcomes["truth"]
    ratio = outcomes["estimate"] / outcomes["truth"]
    rows = outcomes.assign(above=above, below=below, covered=~(above | below), over_truth=ratio).groupby(by, sort=False)
    shares = rows[["covered", "above", "below"]].mean()
    return shares.assign(n=rows.size(), over_truth=rows["over_truth"].median()).reset_index()


STANDARD = 40.0
STANDARD_LEVELS = tuple((STANDARD + np.linspace(-9.0, 9.0, 7)).tolist())
N_AT_STANDARD, EXPONENT = 15, 2.0
"""Number of trials at each level, and exponent of the simulated observer."""
ABOVE_DB = (20.0, 12.0, 6.0, 3.0, 0.0, -3.0)
"""Sensation levels of the standard (dB)."""


def answers_to_standard(above_db: float, n_sets: int, rng: np.random.Generator) -> "np.ndarray":
    """Draw the number of "more" at each level (n_sets, n_levels)."""
    observer = SignalDetectionObserver(exponent=EXPONENT)
    felt = np.array([observer.d_prime(level - STANDARD + above_db) for level in STANDARD_LEVELS])
    more = ndtr((felt - observer.d_prime(above_db)) / np.sqrt(2))
    chance = observer.lapse_rate / 2 + (1 - observer.lapse_rate) * more
    return rng.binomial(N_AT_STANDARD, chance, (n_sets, len(chance)))


FitComparisons = Callable[..., Sequence[ThresholdFit]]


def standards(
    n_studies: int, rng: np.random.Generator, n_people: int = 10, fit: FitComparisons = fit_comparisons, **options: Any
) -> pd.DataFrame:
    """Return PSEs and false effects by the standard's sensation level.

    Studies of `n_people` compare each condition with the first by a paired t-test. The true PSE of both is the
    standard.
    """
    first, rows = None, []
    for above_db in ABOVE_DB:
        n_more = answers_to_standard(above_db, n_studies * n_people, rng)
        result = fit(STANDARD_LEVELS, n_more, N_AT_STANDARD, **(options or FIT))
        pse, low, high = np.array([[getattr(one, name) for name in FITTED[:3]] for one in result], dtype=float).T
        by_study, missed = pse.reshape(n_studies, n_people), (low > STANDARD) | (high < STANDARD)
        false_effects = np.nan
        if first is None:
            first = by_study
        else:
            false_effects = (ttest_rel(first, by_study, axis=1, nan_policy="omit").pvalue < 0.05).mean()
        row = {"above_db": above_db, "rate": float(n_more[:, 0].mean() / N_AT_STANDARD)}
        row |= {"error": float(np.nanmean(pse) - STANDARD), "sd": float(np.nanstd(pse)), "covered": 1 - missed.mean()}
        rows.append(row | {"none": np.isnan(pse).mean(), "false_effects": false_effects})
    return pd.DataFrame(rows)
