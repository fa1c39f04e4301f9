"""An accuracy problem: one workload, a reference, and settings that approach it at a price."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]
OURS = "tactometry"


@dataclass(frozen=True)
class Setting:
    """A computation, with its price unless that is its computing time, and the program it belongs to."""

    name: str
    run: Callable[[], Any]
    price: float | None = None
    contender: str = OURS


@dataclass(frozen=True)
class Reference:
    """A result to compare with: how it is made, and its relative uncertainty."""

    by: str
    answer: Callable[[], Any]
    uncertainty: float


@dataclass(frozen=True)
class Problem:
    """A workload with settings from coarse to fine, grouped by contender.

    Parameters
    ----------
    title : str
    reference : Reference
        By a method other than that of the settings where possible.
    error : callable
        Relative error of a result against the reference, in the norm that `title` states.
    settings : tuple of Setting
    price : str
        The price with its unit.
    name : str
        Key in `PROBLEMS`.
    independent : Reference, optional
        The result by another method, where the reference is our own at its finest.
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
    """Return the largest error of estimate, lower and upper end over the length of the interval."""
    return float(np.abs(interval - reference).max() / (reference[2] - reference[1]))


def largest_relative(answer: Real, reference: Real) -> float:
    """Return the largest error, each over its own value."""
    return float(np.abs(answer / reference - 1).max())


def over_largest(answer: Real, reference: Real) -> float:
    """Return the largest error over the largest value."""
    return float(np.abs(answer - reference).max() / np.abs(reference).max())
