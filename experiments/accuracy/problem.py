"""Types of accuracy problems: workload, reference and settings."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]
OURS = "tactometry"


@dataclass(frozen=True)
class Setting:
    """Computation with its program and price (None: its computing time)."""

    name: str
    run: Callable[[], Any]
    price: float | None = None
    contender: str = OURS


@dataclass(frozen=True)
class Reference:
    """Reference result, with its method and relative uncertainty."""

    by: str
    answer: Callable[[], Any]
    uncertainty: float


@dataclass(frozen=True)
class Problem:
    """Workload with settings from coarse to fine, grouped by contender.

    - `reference`: Reference result, from a different method than the settings if possible.
    - `error`: Function of a result and the reference that returns the relative error. `title` states the norm.
    - `price`: Name of the price, with its unit.
    - `name`: Key in `PROBLEMS`.
    - `independent`: Result of another method, given if the reference is our own method at its finest setting.
    """

    title: str
    reference: Reference
    error: Callable[[Any, Any], float]
    settings: tuple[Setting, ...]
    price: str = "computing time (s)"
    name: str = ""
    independent: Reference | None = None


def error_of_decibels(answer_db: Real, reference_db: Real) -> float:
    """Return the rms error in decibels as a fraction of the amplitude."""
    return float(10 ** (np.sqrt(np.mean(np.square(answer_db - reference_db))) / 20) - 1)


def over_rms(answer: NDArray[Any], reference: NDArray[Any]) -> float:
    """Return the rms error over the rms value."""
    return float(np.linalg.norm(answer - reference) / np.linalg.norm(reference))


def over_interval(interval: Real, reference: Real) -> float:
    """Return the largest error of mean and ends over the interval length."""
    return float(np.abs(interval - reference).max() / (reference[2] - reference[1]))


def largest_relative(answer: Real, reference: Real) -> float:
    """Return the largest relative error."""
    return float(np.abs(answer / reference - 1).max())


def over_largest(answer: Real, reference: Real) -> float:
    """Return the largest error over the largest value."""
    return float(np.abs(answer - reference).max() / np.abs(reference).max())
