"""Ideal participant without noise, lapses and bias."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from ..arguments.constraints import Finite, NotNegative, Positive, constrained
from . import decisions
from .people import ObserverWithTraits, Traits


@dataclass(frozen=True)
@constrained
class IdealObserver(ObserverWithTraits):
    """Noise-free observer that guesses only between equal sensations.

    - `sensitivity_db`: Sensitivity relative to the reference, in dB of sensation level.
    - `between_sd_db`: Standard deviation of the sensitivity between participants.
    - `latency_s`: Time from the stimulus to the answer.

    Raises `InvalidParameter` if a value is out of range.
    """

    sensitivity_db: Finite = 0.0
    between_sd_db: NotNegative = 0.0
    latency_s: Positive = 0.8

    def person(self, traits: Traits) -> Self:
        """Return the participant with these traits: sensitivity and latency."""
        sensitivity_db = self.sensitivity_db + self.between_sd_db * traits.sensitivity
        return replace(self, sensitivity_db=sensitivity_db, latency_s=self.latency_s * traits.latency_factor)

    def detect(self, sensation_db: float, rng: np.random.Generator) -> bool:
        del rng
        return sensation_db + self.sensitivity_db > 0

    def compare(self, sensations_db: Sequence[float], rng: np.random.Generator) -> int:
        best = np.flatnonzero(np.asarray(sensations_db) == max(sensations_db))
        return int(rng.choice(best))

    def identify(self, alternatives_db: Sequence[Sequence[float]], n_felt: int, rng: np.random.Generator) -> int:
        """Return the index of the felt alternative, or of one that feels the same."""
        felt = tuple(alternatives_db[n_felt])
        alike = [n for n, levels in enumerate(alternatives_db) if tuple(levels) == felt]
        return int(rng.choice(alike))

    def differ(self, sensations_db: Sequence[float], rng: np.random.Generator) -> bool:
        del rng
        first, second = sensations_db
        return first != second

    def magnitude(self, sensation_db: float, rng: np.random.Generator) -> float:
        del rng
        return decisions.magnitude(sensation_db + self.sensitivity_db)

    def liking(self, sensation_db: float, rng: np.random.Generator) -> float:
        del rng
        return decisions.liking(sensation_db + self.sensitivity_db)

    def answer_time_s(self, rng: np.random.Generator) -> float:
        del rng
        return self.latency_s
