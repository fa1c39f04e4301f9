"""True thresholds of simulated participants, to compare with estimates."""

from collections.abc import Callable, Iterator
from functools import cache, lru_cache
from math import log10

import pandas as pd
from scipy.special import ndtr, ndtri

from tactometry.analysis.tasks.signal_detection import forced_choice_sensitivity
from tactometry.observers.people import Feeling
from tactometry.observers.signal_detection import SignalDetectionObserver
from tactometry.protocols.tasks.task import Task
from tactometry.rigs.simulated import meeting

from ..study.experiment import Experiment
from ..study.session_plan import Key
from .scenario import growth, middle_of

TRUTH = "truth"
Grown = Callable[[Key], tuple[float, float]]
"""Function that returns the growth of a cell."""


def true_thresholds(experiment: Experiment, codes: list[str], seed: int) -> pd.DataFrame:
    """Return a table of true thresholds by participant and cell.

    The column `TRUTH` contains the thresholds. The table is empty if they are unknown. A threshold is the level at
    which the psychometric function, without lapses and at the requested touch, is half-way between its asymptotes.
    Sensation is extrapolated from the middle of the levels.
    """
    if experiment.table.kind not in ("yes_no", "forced_choice"):
        return pd.DataFrame()
    grown = cache(lambda key: growth(experiment, experiment.cells[key]))  # the same for all participants
    rows = [row for code in codes for row in _of_person(experiment, code, seed, grown)]
    return pd.DataFrame(rows)


def _of_person(experiment: Experiment, code: str, seed: int, grown: Grown) -> Iterator[dict[str, object]]:
    observer, feelings = experiment.simulated_participant(code, seed), experiment.feelings(code, seed)
    for key, cell in experiment.cells.items():
        stimulus = cell.condition.stimulus
        feeling = feelings[meeting(stimulus, cell.condition.touch.request(stimulus, None, None))]
        level = _level(experiment, key, observer, feeling, grown)
        if level is not None:
            yield {"participant": code, **cell.condition.factors, TRUTH: level}


def _level(experiment: Experiment, key: Key, observer: object, feeling: Feeling, grown: Grown) -> float | None:
    if feeling.threshold is not None:
        return feeling.threshold - feeling.deviation_db
    if not isinstance(observer, SignalDetectionObserver):
        return None
    at_db, slope = grown(key)
    own_db = _half_way_db(observer, experiment.task) - feeling.deviation_db
    return middle_of(experiment.cells[key]) + (own_db - at_db) / slope


def _half_way_db(observer: SignalDetectionObserver, task: Task) -> float:
    """Return the half-way sensation level, by inverting the observer's d'."""
    n_intervals = getattr(task, "n_intervals", 0)
    d_prime = half_way_of_choice(n_intervals) if n_intervals else half_way_of_yes(observer.criterion + observer.bias)
    return 20 / observer.exponent * log10(d_prime / observer.criterion) - observer.sensitivity_db


def half_way_of_yes(criterion: float) -> float:
    """Return the d' with a yes rate half-way from false alarms to 1.

    >>> round(half_way_of_yes(1.645), 3)
    1.708
    """
    return float(criterion + ndtri((1 + ndtr(-criterion)) / 2))


@lru_cache(maxsize=8)
def half_way_of_choice(n_intervals: int) -> float:
    """Return the d' with a correct rate half-way from chance to 1.

    Green and Swets (1966), chapter 2.

    >>> round(half_way_of_choice(2), 4)
    0.9539
    """
    return forced_choice_sensitivity((1 + 1 / n_intervals) / 2, n_intervals)
