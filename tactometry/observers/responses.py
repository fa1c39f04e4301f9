"""Responses shared by all observers: liking, magnitude, latency, lapses."""

import math
from typing import Final

import numpy as np

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
