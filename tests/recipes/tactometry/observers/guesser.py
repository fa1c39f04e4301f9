"""A participant who feels nothing, and guesses."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from ..arguments.require import below_1


@dataclass(frozen=True)
class Guesser:
    """Says yes with the chance `bias`, whatever is felt."""

    bias: float = 0.5

    def __post_init__(self) -> None:
        below_1("Guesser", bias=self.bias)

    def participant(self, rng: np.random.Generator) -> Self:
        del rng
        return self

    def detect(self, sensation_db: float, rng: np.random.Generator) -> bool:
        del sensation_db
        return bool(rng.random() < self.bias)

    def compare(self, sensations_db: Sequence[float], rng: np.random.Generator) -> int:
        return int(rng.integers(len(sensations_db)))

    def identify(self, alternatives_db: Sequence[Sequence[float]], n_felt: int, rng: np.random.Generator) -> int:
        del n_felt
        return int(rng.integers(len(alternatives_db)))

    def differ(self, sensations_db: Sequence[float], rng: np.random.Generator) -> bool:
        return self.detect(sensations_db[0], rng)

    def magnitude(self, sensation_db: float, rng: np.random.Generator) -> float:
        del sensation_db
        return float(rng.random())

    def liking(self, sensation_db: float, rng: np.random.Generator) -> float:
        del sensation_db
        return float(rng.uniform(-1, 1))

    def answer_time_s(self, rng: np.random.Generator) -> float:
        return float(rng.uniform(0.2, 0.4))

    def facts(self) -> dict[str, str | int | float | bool | None]:
        return {"kind": "Guesser", "bias": self.bias}
