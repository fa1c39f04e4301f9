"""What a trial is: how it is presented, and what is asked."""

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from tactometry.protocols.touch import Touch
from tactometry.request import Chosen, Touched
from tactometry.run import Course


@dataclass(frozen=True)
class Outcome:
    """What came of one presentation. `response` is None if a touch or the answer was not valid."""

    touches: tuple[Touched, ...]
    stimulus: Touched | None
    choice: Chosen | None = None
    correct: bool | None = None
    target: int | None = None

    @property
    def valid(self) -> bool:
        return all(touch.valid for touch in self.touches) and self.choice is not None and self.choice.valid


@dataclass(frozen=True)
class Presentation:
    """A stimulus at a level; None is a catch trial."""

    stimulus: str
    level: float | None
    touch: Touch = field(repr=False)


class Task(Protocol):
    """The course of one trial."""

    @property
    def name(self) -> str: ...

    @property
    def takes_catch_trials(self) -> bool: ...

    def trial(self, shown: Presentation, rng: np.random.Generator) -> Course[Outcome]: ...
