"""A ladder: one problem, a reference, and settings that come nearer to it at a price."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]
OURS = "tactometry"


@dataclass(frozen=True)
class Rung:
    """A setting in words, the computation with it, its price if that is not the time of computing, and whose it is."""

    setting: str
    run: Callable[[], Any]
    price: float | None = None
    contender: str = OURS


@dataclass(frozen=True)
class Reference:
    """What a ladder is held against, in words; its answer, and the relative uncertainty of that."""

    by: str
    answer: Callable[[], Any]
    uncertainty: float


@dataclass(frozen=True)
class Problem:
    """A workload with rungs from coarse to fine, those of each contender together.

    Parameters
    ----------
    title : str
    reference : Reference
    independent : Reference
        The same by another way.
    error : callable
        Of an answer against the reference's: relative, in the norm that `title` states.
    rungs : tuple of Rung
    price : str
        What is paid, with its unit, in words.
    name : str
        That of the table `LADDERS`.
    """

    title: str
    reference: Reference
    independent: Reference
    error: Callable[[Any, Any], float]
    rungs: tuple[Rung, ...]
    price: str = "computing time (s)"
    name: str = ""


def error_of_decibels(answer_db: Real, reference_db: Real) -> float:
    """An rms error in decibels, as a part of the amplitude."""
    return float(10 ** (np.sqrt(np.mean(np.square(answer_db - reference_db))) / 20) - 1)


def over_rms(answer: NDArray[Any], reference: NDArray[Any]) -> float:
    """The rms error, over the rms value."""
    return float(np.linalg.norm(answer - reference) / np.linalg.norm(reference))


def over_interval(interval: Real, reference: Real) -> float:
    """The largest error of an estimate, its lower and its upper end, over the distance of the ends."""
    return float(np.abs(interval - reference).max() / (reference[2] - reference[1]))


def largest_relative(answer: Real, reference: Real) -> float:
    """The largest error, each over its own value."""
    return float(np.abs(answer / reference - 1).max())


def over_largest(answer: Real, reference: Real) -> float:
    """The largest error, over the largest value."""
    return float(np.abs(answer - reference).max() / np.abs(reference).max())
