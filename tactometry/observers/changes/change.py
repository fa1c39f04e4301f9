"""What a change of a participant during a session is."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, Self, runtime_checkable

import numpy as np

from ..responses import either

Answer = float | str | None
"""The response of a row."""


@dataclass(frozen=True)
class Shift:
    """By how much a participant is off in one trial: more sensitive, more reluctant to say yes (in units of the
    internal noise), and with lapses beside the usual ones."""

    sensitivity_db: float = 0.0
    criterion: float = 0.0
    lapse_rate: float = 0.0

    def __add__(self, other: "Shift") -> "Shift":
        """Both: who lapses for one reason cannot lapse for another.

        >>> Shift(1.0, lapse_rate=0.5) + Shift(2.0, lapse_rate=0.5)
        Shift(sensitivity_db=3.0, criterion=0.0, lapse_rate=0.75)
        """
        return Shift(
            self.sensitivity_db + other.sensitivity_db,
            self.criterion + other.criterion,
            either(self.lapse_rate, other.lapse_rate),
        )


class Change(Protocol):
    """A pure function of how many trials were before, what was answered in them, and a stream of its own, which stands
    at its beginning in every trial."""

    def shift(self, n_trials: int, answers: Sequence[Answer], rng: np.random.Generator) -> Shift: ...


@runtime_checkable
class Shifted(Protocol):
    """An observer that can be off."""

    def shifted(self, shift: Shift) -> Self: ...
