"""Interface of observers, and answers to questions from sensations."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np

from ..session.request import Choose, Facts


class Observer(Protocol):
    """Observer that decides from levels in dB re threshold (-inf: no stimulus)."""

    def detect(self, sensation_db: float, rng: np.random.Generator) -> bool:
        """Return True if a stimulus is reported as felt."""

    def compare(self, sensations_db: Sequence[float], rng: np.random.Generator) -> int:
        """Return the index of the strongest sensation."""

    def identify(self, alternatives_db: Sequence[Sequence[float]], n_felt: int, rng: np.random.Generator) -> int:
        """Return the index of the alternative that the observer reports.

        `n_felt` is the index of the presented alternative. `alternatives_db` contains the sensation levels of each
        alternative at each place of the skin.
        """

    def differ(self, sensations_db: Sequence[float], rng: np.random.Generator) -> bool:
        """Return True if two stimuli are reported as different."""

    def magnitude(self, sensation_db: float, rng: np.random.Generator) -> float:
        """Return the perceived intensity, at least 0."""

    def liking(self, sensation_db: float, rng: np.random.Generator) -> float:
        """Return the pleasantness, from -1 to 1."""

    def answer_time_s(self, rng: np.random.Generator) -> float: ...

    def facts(self) -> Facts: ...


@dataclass(frozen=True)
class Felt:
    """Stimulus that was felt in this trial, with its sensation level.

    `fingers_db` returns what each finger would feel of any stimulus in the same touch. None means a single place of
    the skin.
    """

    stimulus: str
    level_db: float
    fingers_db: Callable[[str], tuple[float, ...]] | None = None


Decide = Callable[[Observer, Sequence[Felt], Choose, np.random.Generator], int]
"""Function from the felt stimuli to one of the options."""


@dataclass(frozen=True)
class Decision:
    """Rule that answers a question, and the number of stimuli it needs.

    If `n_stimuli` is None, it needs one stimulus for each option.
    """

    decide: Decide
    n_stimuli: int | None = None


def detect(observer: Observer, felt: Sequence[Felt], request: Choose, rng: np.random.Generator) -> int:
    return request.options[int(observer.detect(felt[0].level_db, rng))]


def differ(observer: Observer, felt: Sequence[Felt], request: Choose, rng: np.random.Generator) -> int:
    return request.options[int(observer.differ([each.level_db for each in felt], rng))]


def strongest(observer: Observer, felt: Sequence[Felt], request: Choose, rng: np.random.Generator) -> int:
    return request.options[observer.compare([each.level_db for each in felt], rng)]


def most_liked(observer: Observer, felt: Sequence[Felt], request: Choose, rng: np.random.Generator) -> int:
    return request.options[int(np.argmax([observer.liking(each.level_db, rng) for each in felt]))]


def locate(observer: Observer, felt: Sequence[Felt], request: Choose, rng: np.random.Generator) -> int:
    """Return which alternative was felt, from the levels at each finger.

    Without `fingers_db`, each alternative is felt at a separate place.
    """
    last, names = felt[-1], request.stimuli
    apart = ([last.level_db if name == place else float("-inf") for place in names] for name in names)
    levels_db = list(apart) if last.fingers_db is None else [last.fingers_db(name) for name in names]
    return request.options[observer.identify(levels_db, names.index(last.stimulus), rng)]


COMFORT_DB: Final = 15.0
COMFORT_RANGE_DB: Final = 25.0
HIGHEST_DB: Final = 300.0
"""Level as which higher sensation levels are reported."""
MOST_LAPSES: Final = 0.5
"""Largest lapse rate drawn for a participant."""
ALMOST_ALL: Final = 0.999999
"""Largest rate of lapses, or of lapses and guesses together."""
LATENCY_CV: Final = 0.3
"""Standard deviation of the logarithm of the response time; range: `responses` in `stimuli/sources.toml`."""


def liking(level_db: float) -> float:
    """Return the pleasantness of a level, from -1 to 1.

    >>> liking(15.0), liking(27.5), liking(float("-inf"))
    (1.0, 0.0, -1.0)
    """
    return 1 - 2 * min(abs(level_db - COMFORT_DB) / COMFORT_RANGE_DB, 1.0)


def magnitude(level_db: float) -> float:
    """Return the amplitude of a level re threshold, to three digits.

    >>> magnitude(40.0), magnitude(float("-inf"))
    (100.0, 0.0)
    """
    return in_words(10 ** (min(level_db, HIGHEST_DB) / 20))


def in_words(number: float) -> float:
    """Round a number to three digits, as participants state numbers.

    >>> in_words(1234.5)
    1230.0
    """
    return float(f"{number:.3g}")


def answer_time_s(median_s: float, rng: np.random.Generator) -> float:
    return float(median_s * math.exp(LATENCY_CV * float(rng.standard_normal())))


def either(lapse_rate: float, other: float) -> float:
    """Combine two independent lapse rates.

    >>> either(0.5, 0.5)
    0.75
    """
    return 1 - (1 - lapse_rate) * (1 - other)
