"""How often intervals of just noticeable differences and points of subjective equality hold the truth, by the spread
of the function, trials and lapses (`python benchmarks/census_comparisons.py`).

A lapse is an answer that is "more" or "less" with the same chance, whatever was felt: at a rate of 5 % the asymptotes
are 0.025 and 0.975. Points of equality lie anywhere in the middle quarter of the levels.
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
from tactometry.analysis.threshold.result import ThresholdFit
from tactometry.observers.signal_detection import SignalDetectionObserver

LEVELS = tuple(np.linspace(-6.0, 6.0, 7).tolist())
SDS, N_TRIALS, LAPSE_RATES = (1.5, 2.5), (20, 40), (0.0, 0.02, 0.03, 0.05)
FARTHEST_PSE = 1.5
WITHOUT_LAPSES: Mapping[str, Any] = {"shape": SHAPE, "guess_rate": 0.0, "lapse_rate": 0.0}


@dataclass(frozen=True)
class Person:
    """Standard deviation of the function, trials at each level, and the share of trials without attention."""

    sd: float
    n_trials: int
    lapse_rate: float


PEOPLE = tuple(Person(*each) for each in product(SDS, N_TRIALS, LAPSE_RATES))


def answers(person: Person, n_sets: int, rng: np.random.Generator) -> tuple["np.ndarray", "np.ndarray"]:
    """True points of equality (n_sets,), and how often each level was "more" (n_sets, n_levels)."""
    pse = rng.uniform(-FARTHEST_PSE, FARTHEST_PSE, n_sets)
    felt = ndtr((np.array(LEVELS) - pse[:, None]) / person.sd)
    return pse, rng.binomial(person.n_trials, person.lapse_rate / 2 + (1 - person.lapse_rate) * felt)


def census(
    people: Sequence[Person], n_sets: int, rng: np.random.Generator, options: Mapping[str, Any] = FIT
) -> Iterator[pd.DataFrame]:
    """A table for each person, with a row for each of `n_sets` data sets, fitted as `analyse` does, or with other
    `options` of `fit`. Open ends of intervals, and those that are not told, hold all on their side."""
    for person in people:
        pse, n_more = answers(person, n_sets, rng)
        fitted = fit_comparisons(LEVELS, n_more, person.n_trials, **options)
        told = [
            [one.threshold, one.interval_low, one.interval_high, one.jnd, one.jnd_low, one.jnd_high] for one in fitted
        ]
        table = pd.DataFrame(told, columns=["pse", "pse_low", "pse_high", "jnd", "jnd_low", "jnd_high"], dtype=float)
        named = {"sd": person.sd, "n_trials": person.n_trials, "lapse_rate": person.lapse_rate}
        yield table.assign(**named, true_pse=pse, true_jnd=JND_PER_SD * person.sd)


def summary(outcomes: pd.DataFrame) -> pd.DataFrame:
    """Of each person: data sets, share of the intervals that hold the difference, that lie above it and below it, that
    hold the point of equality, and the median of the differences over the truth."""
    rows = [(*key, *_row(each)) for key, each in outcomes.groupby(["sd", "n_trials", "lapse_rate"], sort=False)]
    return pd.DataFrame(rows, columns=["sd", "n_trials", "lapse_rate", *COLUMNS])


COLUMNS = ("n", "jnd_covered", "jnd_above", "jnd_below", "pse_covered", "jnd_over_truth")


def _row(rows: pd.DataFrame) -> tuple[float, ...]:
    above, below = ((rows["jnd_low"] > rows["true_jnd"]).mean(), (rows["jnd_high"] < rows["true_jnd"]).mean())
    missed = (rows["pse_low"] > rows["true_pse"]) | (rows["pse_high"] < rows["true_pse"])
    return len(rows), 1 - above - below, above, below, 1 - missed.mean(), (rows["jnd"] / rows["true_jnd"]).median()


STANDARD = 40.0
STANDARD_LEVELS = tuple((STANDARD + np.linspace(-9.0, 9.0, 7)).tolist())
N_AT_STANDARD, EXPONENT = 15, 2.0
"""Trials at each level, and the exponent of the simulated observer."""
ABOVE_DB = (20.0, 12.0, 6.0, 3.0, 0.0, -3.0)
"""Sensation levels of the standard."""


def answers_to_standard(above_db: float, n_sets: int, rng: np.random.Generator) -> "np.ndarray":
    """Return how often each level was "more" (n_sets, n_levels), by the chances of the simulated observer.

    The standard is so far above its detection threshold; the lapse rate is that of the observer.
    """
    observer = SignalDetectionObserver(exponent=EXPONENT)
    felt = np.array([observer.d_prime(level - STANDARD + above_db) for level in STANDARD_LEVELS])
    more = ndtr((felt - observer.d_prime(above_db)) / np.sqrt(2))
    chance = observer.lapse_rate / 2 + (1 - observer.lapse_rate) * more
    return rng.binomial(N_AT_STANDARD, chance, (n_sets, len(chance)))


FitComparisons = Callable[..., Sequence[ThresholdFit]]


def standard_census(
    n_studies: int, rng: np.random.Generator, n_people: int = 10, fit: FitComparisons = fit_comparisons, **options: Any
) -> pd.DataFrame:
    """Return a row for each distance of the standard from threshold: PSE, and false effects against the first row.

    Studies of `n_people` compare each condition with the first by a paired t-test; both have their PSE at the standard.
    """
    first: np.ndarray | None = None
    rows: list[tuple[float, ...]] = []
    for above_db in ABOVE_DB:
        n_more = answers_to_standard(above_db, n_studies * n_people, rng)
        fits = fit(STANDARD_LEVELS, n_more, N_AT_STANDARD, **(options or FIT))
        ends = [(one.threshold, one.interval_low, one.interval_high) for one in fits]
        pse, low, high = np.array(ends, dtype=float).T
        missed = (low > STANDARD) | (high < STANDARD)
        by_study = pse.reshape(n_studies, n_people)
        first = by_study if first is None else first
        p = ttest_rel(first, by_study, axis=1, nan_policy="omit").pvalue if rows else np.full(n_studies, np.nan)
        rate = float(n_more[:, 0].mean() / N_AT_STANDARD)
        error, sd = float(np.nanmean(pse) - STANDARD), float(np.nanstd(pse))
        found = (above_db, rate, error, sd, 1 - missed.mean(), np.isnan(pse).mean())
        rows.append((*found, (p < 0.05).mean() if rows else np.nan))
    return pd.DataFrame(rows, columns=["above_db", "rate", "error", "sd", "covered", "none", "false_effects"])
