"""Base classes of procedures: settings (`Rule`) and runs (`Run`)."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Any, ClassVar, Generic, Literal, Protocol, Self, TypeVar, runtime_checkable

import numpy as np
from annotated_types import Ge

from tactometry.arguments.constraints import excerpt, is_number
from tactometry.arguments.require import expect
from tactometry.errors import InvalidParameter

Count = Annotated[int, Ge(1)]
MOST_TRIALS = 1_000_000
"""Largest number of trials. At 5 s each they would take 58 days."""
Ending = Literal["converged", "trials", "censored_above", "censored_below", "aborted"]


@dataclass(frozen=True)
class RuleThreshold:
    """Estimate of a rule: level, SD, count, and type or reason of absence."""

    level: float | None = None
    sd: float | None = None
    n: int | None = None
    note: str = ""


class Procedure(ABC):
    """Immutable rule for the next level, before or after answers.

    `after` returns the procedure that follows a response (1 or True: correct, or "felt"). The rule uses the level
    that was *delivered*, even if it requested another level.
    """

    learns_from_easy: ClassVar[bool] = False
    """True if answers to easy trials (`easy.EasyTrials`) are passed to the procedure."""

    @property
    @abstractmethod
    def name(self) -> str:
        """Name in the column `procedure` of a trials table."""

    @property
    @abstractmethod
    def bounds(self) -> tuple[float, float]:
        """Lowest and highest level that the procedure may request."""

    @property
    @abstractmethod
    def n_trials_at_most(self) -> int:
        """Largest number of answers."""

    @property
    @abstractmethod
    def level(self) -> float:
        """Level of the next trial."""

    @property
    @abstractmethod
    def ending(self) -> Ending | None:
        """Reason why the procedure ended, or None while it runs."""

    @property
    @abstractmethod
    def estimate(self) -> RuleThreshold:
        """Threshold estimate and how it was obtained."""

    @abstractmethod
    def after(self, response: int | bool, delivered: float | None = None) -> "Procedure":
        """Return the procedure after a response to the delivered level.

        Raises `InvalidParameter` if the response is not an outcome of the rule, the level is not a finite number, or
        the procedure has finished.
        """

    @property
    def finished(self) -> bool:
        return self.ending is not None

    @property
    def is_easy(self) -> bool:
        """True if the next trial is an easy trial at a fixed level."""
        return False

    @property
    def threshold(self) -> float | None:
        """Estimate from the answers so far, in the unit of the levels, or None."""
        return self.estimate.level

    def learning_from(self, other: "Procedure") -> Self:
        """Return this procedure after an answer on another track."""
        del other
        return self


class FixedOrder(Procedure):
    """Procedure in a fixed order, whatever the responses. Levels can be postponed."""

    @abstractmethod
    def skip(self) -> "FixedOrder":
        """Return the procedure at the next presentation, postponing this one."""

    @abstractmethod
    def take(self, response: int | bool) -> "FixedOrder":
        """Return the procedure with one more answer, at the same presentation."""


class DelegatingProcedure(Procedure):
    """Procedure that delegates to another procedure, its `view`."""

    @property
    @abstractmethod
    def view(self) -> Procedure: ...

    @property
    def bounds(self) -> tuple[float, float]:
        return self.view.bounds

    @property
    def n_trials_at_most(self) -> int:
        return self.view.n_trials_at_most

    @property
    def level(self) -> float:
        return self.view.level

    @property
    def ending(self) -> Ending | None:
        return self.view.ending

    @property
    def estimate(self) -> RuleThreshold:
        return self.view.estimate


RunT = TypeVar("RunT", bound="Run[Any]")
RuleT = TypeVar("RuleT", bound="Rule[Any]")


@runtime_checkable
class OfLevels(Protocol):
    """Rule that requests only its `levels`, at least one."""

    levels: tuple[float, ...]


class Rule(DelegatingProcedure, Generic[RunT]):
    """Settings of a procedure, which is also its run before any answer."""

    low: float
    high: float
    n_trials: int
    unreplayed: ClassVar[str] = ""
    """Reason why answers and levels do not determine a run, or empty."""

    @property
    def bounds(self) -> tuple[float, float]:
        ends = self.levels if isinstance(self, OfLevels) else (self.low, self.high)
        return min(ends), max(ends)

    @property
    def n_trials_at_most(self) -> int:
        return self.n_trials

    @abstractmethod
    def begin(self, rng: np.random.Generator | None = None) -> RunT:
        """Return a run without answers, with an order drawn by `rng` if needed."""

    def begin_together(self, tracks: Sequence[str]) -> "tuple[Procedure, ...]":
        """Return procedures for tracks that may learn from each other."""
        return tuple(self.begin() for _ in tracks)

    @property
    def n_outcomes(self) -> int:
        """Number of different answers, reported as 0, 1, ..."""
        return 2

    @cached_property
    def view(self) -> RunT:
        return self.begin()

    def after(self, response: int | bool, delivered: float | None = None) -> RunT:
        return self.view.after(response, delivered)


@dataclass(frozen=True)
class Run(Procedure, Generic[RuleT]):
    """A rule and its history of responses and delivered levels."""

    rule: RuleT
    responses: tuple[int, ...] = ()
    delivered: tuple[float, ...] = ()

    @property
    def name(self) -> str:
        return self.rule.name

    @property
    def bounds(self) -> tuple[float, float]:
        return self.rule.bounds

    @property
    def n_trials_at_most(self) -> int:
        return self.rule.n_trials_at_most

    @cached_property
    def estimate(self) -> RuleThreshold:
        if self.ending in ("censored_above", "censored_below", "aborted"):
            return RuleThreshold(note=f"the rule ended as {self.ending}")
        return self._estimate() if self.responses else RuleThreshold(note="no answer")

    def after(self, response: int | bool, delivered: float | None = None) -> Self:
        owner = type(self.rule).__name__
        outcome = checked_outcome(response, self.rule.n_outcomes, owner)
        if self.finished:
            raise InvalidParameter(f"{owner}.after: found a response after the end of the procedure, expected none")
        level = self.level if delivered is None else delivered
        expect(is_number(level), f"{owner}.after", f"the delivered level {excerpt(level)}", "a finite number")
        return replace(self, responses=(*self.responses, outcome), delivered=(*self.delivered, level))._updated()

    @abstractmethod
    def _updated(self) -> Self:
        """Update the state with the last response of the history."""

    @abstractmethod
    def _estimate(self) -> RuleThreshold:
        """Return the estimate of a run with answers that ended regularly."""


def checked_outcome(response: object, n_outcomes: int, procedure: str) -> int:
    """Return `response` as the number of an outcome, from 0.

    Raises `InvalidParameter` if it is not an outcome. An unanswered trial must be repeated, not counted as wrong.
    """
    if n_outcomes == 2 and isinstance(response, int | float | np.bool_ | np.number) and response in (0, 1):
        return int(response)
    if isinstance(response, int | np.integer) and 0 <= response < n_outcomes:
        return int(response)
    expected = f"a whole number from 0 to {n_outcomes - 1}"
    if n_outcomes == 2:
        expected = "1 (correct, felt) or 0; repeat the trial if it was not answered"
    raise InvalidParameter(f"{procedure}.after: found the response {response!r}, expected {expected}")


def after_answer(
    procedures: Sequence[Procedure], index: int, response: int | bool, delivered: float | None = None
) -> tuple[Procedure, ...]:
    """Return all procedures after an answer to one of them.

    >>> from tactometry.protocols import ConstantStimuli
    >>> first, second = after_answer((ConstantStimuli((1.0,), 1), ConstantStimuli((2.0,), 1)), 0, 1)
    >>> first.finished, second.finished
    (True, False)
    """
    moved = procedures[index].after(response, delivered)
    return tuple(moved if n == index else other.learning_from(moved) for n, other in enumerate(procedures))
