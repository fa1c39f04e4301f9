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

    def identify(self, alternatives_db: Sequence[Sequence[float]], n_felt: int, rng: np.random.Generator) -> int:
        """The index of the alternative that it is taken for: each is known by the level at each place of the skin, and
        number `n_felt`, from 0, is felt."""

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
    """A stimulus that was felt in this trial, with its sensation level.

    `fingers_db` says what each finger feels of it, or would have felt of another stimulus in the same touch; None: the
    skin feels it at one place, and each other stimulus apart from it.
    """

    stimulus: str
    level_db: float
    fingers_db: Callable[[str], tuple[float, ...]] | None = None


Decide = Callable[[Observer, Sequence[Felt], Choose, np.random.Generator], int]
"""From what was felt to one of the options."""


@dataclass(frozen=True)
class Decision:
    """How a question is answered, and after how many stimuli (None: one for each option)."""

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
    """By what each finger feels of each alternative; without fingers each is felt at a place of its own alone."""
    last, names = felt[-1], request.stimuli
    apart = ([last.level_db if name == place else float("-inf") for place in names] for name in names)
    levels_db = list(apart) if last.fingers_db is None else [last.fingers_db(name) for name in names]
    return request.options[observer.identify(levels_db, names.index(last.stimulus), rng)]
