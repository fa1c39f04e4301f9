"""What every model of a participant is, and what it answers to a choice from what it felt in the trial."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ..session.request import Choose, Facts


class Observer(Protocol):
    """Decides from sensation levels (dB re the detection threshold, -inf for nothing), never from a nominal level."""

    def detect(self, sensation_db: float, rng: np.random.Generator) -> bool:
        """Whether a stimulus is reported as felt."""

    def compare(self, sensations_db: Sequence[float], rng: np.random.Generator) -> int:
        """The index of the one that is felt most."""

    def differ(self, sensations_db: Sequence[float], rng: np.random.Generator) -> bool:
        """Whether two stimuli are reported as different."""

    def magnitude(self, sensation_db: float, rng: np.random.Generator) -> float:
        """How strong it felt, a number from 0."""

    def liking(self, sensation_db: float, rng: np.random.Generator) -> float:
        """How good it felt, from -1 to 1."""

    def answer_time_s(self, rng: np.random.Generator) -> float: ...

    def facts(self) -> Facts: ...


@dataclass(frozen=True)
class Felt:
    """A stimulus that was felt in this trial, with its sensation level."""

    stimulus: str
    level_db: float


Decide = Callable[[Observer, Sequence[Felt], Choose, np.random.Generator], int]
"""From what was felt to one of the options."""


@dataclass(frozen=True)
class Decision:
    """How a question is answered, and after how many stimuli (None: one for each option)."""

    decide: Decide
    n_stimuli: int | None = None


def detect(observer: Observer, felt: Sequence[Felt], request: Choose, rng: np.random.Generator) -> int:
    """The second option if anything was felt."""
    return request.options[int(observer.detect(felt[0].level_db, rng))]


def differ(observer: Observer, felt: Sequence[Felt], request: Choose, rng: np.random.Generator) -> int:
    """The second option if two stimuli felt different."""
    return request.options[int(observer.differ([each.level_db for each in felt], rng))]


def strongest(observer: Observer, felt: Sequence[Felt], request: Choose, rng: np.random.Generator) -> int:
    """The option of what was felt most."""
    return request.options[observer.compare([each.level_db for each in felt], rng)]


def most_liked(observer: Observer, felt: Sequence[Felt], request: Choose, rng: np.random.Generator) -> int:
    """The option of what felt best."""
    return request.options[int(np.argmax([observer.liking(each.level_db, rng) for each in felt]))]


def locate(observer: Observer, felt: Sequence[Felt], request: Choose, rng: np.random.Generator) -> int:
    """Each place is felt apart: the sensation at the one that was stimulated, nothing but noise at the others."""
    levels_db = [felt[-1].level_db if name == felt[-1].stimulus else float("-inf") for name in request.stimuli]
    return request.options[observer.compare(levels_db, rng)]
