"""Tasks: presentation of a trial, its questions and their outcome."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Protocol, Self, runtime_checkable

import numpy as np

from tactometry.arguments.constraints import Finite, constrained
from tactometry.observers.decisions import Decision
from tactometry.questionnaire import Questionnaire
from tactometry.session.answer import Answer, Chosen, Touched
from tactometry.session.run import Course
from tactometry.trials.trial import Reason

from .touch import Touch, feel_in_turn, nth

Place = tuple[float, float]
"""Coordinates of a point (m)."""
Places = tuple[Place, ...]


@dataclass(frozen=True)
class Alternative:
    """Stimulus that a trial chooses among, with label and places."""

    stimulus: str
    label: str
    factors: Mapping[str, float | str] = field(default_factory=dict)
    places_m: Places = ()


@dataclass(frozen=True)
class Presentation:
    """Stimulus at a level, or a catch trial for None."""

    stimulus: str
    level: float | None
    touch: Touch = field(repr=False)
    alternatives: tuple[Alternative, ...] = ()


@dataclass(frozen=True)
class Reply:
    """Cells of an answer. Without a response the question was left open."""

    answer: Answer | None = None
    response: float | None = None
    correct: bool | None = None
    item: str | None = None
    item_b: str | None = None
    level_measured: float | None = None


@dataclass(frozen=True)
class TrialOutcome:
    """Outcome of one presentation, with a row for each reply.

    `stimulus` is the touch whose delivered level counts. `success` is the response for the procedure (None: no
    response). `factors` are the levels that the trial chose. `rule` replaces the procedure's name in its column.
    `separation_m` and `error_m` are distances between alternatives that have places.
    """

    touches: tuple[Touched, ...]
    stimulus: Touched | None = None
    replies: tuple[Reply, ...] = ()
    success: bool | None = None
    target: int | None = None
    standard_level: float | None = None
    factors: Mapping[str, float | str] = field(default_factory=dict)
    rule: str | None = None
    separation_m: float | None = None
    error_m: float | None = None

    @property
    def valid(self) -> bool:
        """True if all touches and answers are valid."""
        return bool(self.replies) and all(each.valid for each in self._parts)

    @property
    def touches_valid(self) -> bool:
        return all(touch.valid for touch in self.touches)

    def score(self, choice: Chosen, *, correct: bool) -> Self:
        """Return the outcome with a right or wrong choice."""
        return replace(self, replies=(Reply(choice, choice.option, correct),), success=correct)

    @property
    def _parts(self) -> tuple[Touched | Answer, ...]:
        return (*self.touches, *(reply.answer for reply in self.replies if reply.answer is not None))

    @property
    def correct(self) -> bool | None:
        """True if the answer is right, None if it is invalid or cannot be scored."""
        return self.replies[0].correct if self.valid else None

    @property
    def invalid_reason(self) -> Reason | None:
        """Reason why the first touch or answer does not count, or None."""
        return next((each.invalid_reason for each in self._parts if not each.valid), None)

    @property
    def n_gaps(self) -> int | None:
        """Number of gaps of the output, None if the output reports none."""
        known = [each.n_gaps for each in self._parts if each.n_gaps is not None]
        return sum(known) if known else None

    @property
    def onset_s(self) -> float:
        """Onset of the first stimulus, or else of the first question."""
        return self._parts[0].onset_s


TrialCourse = Course[TrialOutcome]


@runtime_checkable
class Task(Protocol):
    """Task, with the course of one trial."""

    @property
    def name(self) -> str: ...

    takes_catch_trials: bool = False

    def trial(self, shown: Presentation, rng: np.random.Generator) -> TrialCourse: ...


@dataclass(frozen=True)
@constrained
class AgainstStandard(Task):
    """Task that compares a level with a standard.

    - `standard_level`: Level with which every other level is compared.
    """

    standard_level: Finite

    def feel(self, shown: Presentation, level: float | None, rng: np.random.Generator) -> TrialCourse:
        """Present the standard and a level in random order."""
        target = int(rng.integers(1, 3))
        levels = [level if interval == target else self.standard_level for interval in (1, 2)]
        touches = yield from feel_in_turn(shown.touch, [shown.stimulus] * 2, levels)
        return TrialOutcome(touches, nth(touches, target), target=target, standard_level=self.standard_level)


@runtime_checkable
class AsksForm(Protocol):
    """Task that asks a questionnaire in each trial."""

    @property
    def form(self) -> Questionnaire: ...


@dataclass(frozen=True)
class Over:
    """Factor whose levels are the alternatives of a trial.

    - `over`: Name of the factor whose levels a trial chooses among.
    """

    over: str


@dataclass(frozen=True)
class TaskKind:
    """Properties of a task that a study needs before a session.

    - `table`: Class that reads the task's keys in the table `task`. It is `Over` for a task that chooses among
      `alternatives`.
    - `example`: Example of keys for `table`, with levels from 0 to 40.
    - `questions`: Decision rules of a simulated participant for each `Choose` of a trial, by its `question`.
    - `made`: Function that creates the task from the table and a function that finds questionnaires by name.
    - `n_together`: Number of alternatives in a track, with a track for every combination. None puts all alternatives
      into one track.
    - `own_levels`: Attributes with levels that the task plays in addition to those of the procedure.
    - `check_levels`: Function of the task and the procedure's lowest and highest level that refuses unsuitable levels.
    """

    table: type
    example: Mapping[str, object] = field(default_factory=dict)
    questions: Mapping[str, Decision] = field(default_factory=dict)
    made: Callable[[Any, Callable[[str], Questionnaire]], Task] = lambda table, form_of: table
    n_together: int | None = None
    own_levels: tuple[str, ...] = ()
    check_levels: Callable[[Any, float, float], None] = lambda task, low, high: None
