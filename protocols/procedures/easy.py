"""Easy trials of adaptive procedures, from which the lapse rate is estimated."""

from dataclasses import dataclass, replace
from math import ceil
from typing import Self

import numpy as np

from tactometry.errors import InvalidParameter

from .procedure import DelegatingProcedure, Ending, Procedure


@dataclass(frozen=True)
class EasyTrials(DelegatingProcedure):
    """Adaptive procedure with easy trials at `places` (from 0).

    A staircase ignores the answers to easy trials, a Bayesian procedure uses them. They count towards the largest
    number of trials.

    >>> from tactometry.protocols import Staircase
    >>> rule = Staircase(20.0, (4.0,), 0.0, 40.0, n_down=1)
    >>> track = EasyTrials(rule, 40.0, frozenset([1]))
    >>> track = track.after(1)
    >>> (track.is_easy, track.level), (track.after(0).is_easy, track.after(0).level)
    ((True, 40.0), (False, 16.0))
    """

    procedure: Procedure
    easy_level: float
    places: frozenset[int]
    n_answers: int = 0

    @property
    def view(self) -> Procedure:
        return self.procedure

    @property
    def is_easy(self) -> bool:
        return self.n_answers in self.places

    @property
    def name(self) -> str:
        return self.view.name

    @property
    def level(self) -> float:
        return self.easy_level if self.is_easy else self.view.level

    @property
    def ending(self) -> Ending | None:
        return self.view.ending or ("trials" if self.n_answers >= self.n_trials_at_most else None)

    def after(self, response: int | bool, delivered: float | None = None) -> Self:
        if self.finished:
            raise InvalidParameter("EasyTrials.after: found a response after the end of the procedure, expected none")
        level = self.level if delivered is None else delivered
        learns = not self.is_easy or self.view.learns_from_easy
        procedure = self.view.after(response, level) if learns else self.view
        return replace(self, procedure=procedure, n_answers=self.n_answers + 1)

    def learning_from(self, other: Procedure) -> Self:
        procedure = self.view.learning_from(other.view if isinstance(other, EasyTrials) else other)
        return self if procedure is self.procedure else replace(self, procedure=procedure)


def with_easy_trials(procedure: Procedure, share: float, easy_level: float, rng: np.random.Generator) -> EasyTrials:
    """Return a procedure with one easy trial in each round(1 / share).

    >>> from tactometry.protocols import Staircase
    >>> rule = Staircase(20.0, (4.0,), 0.0, 40.0, n_trials=40)
    >>> sorted(n // 10 for n in with_easy_trials(rule, 0.1, 40.0, np.random.default_rng(1)).places)
    [0, 1, 2, 3]
    """
    n_group = round(1 / share)
    n_groups = ceil(procedure.n_trials_at_most / n_group)
    places = np.arange(n_groups) * n_group + rng.integers(n_group, size=n_groups)
    return EasyTrials(procedure, easy_level, frozenset(places.tolist()))
