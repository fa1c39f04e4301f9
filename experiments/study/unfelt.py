"""Conditions whose strongest level lies below the predicted detection threshold, or whose standard lies near it."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from math import inf

from tactometry.observers.people import Feeling, Stated
from tactometry.protocols.tasks.task import AgainstStandard
from tactometry.trials.cells import cell as cell_text

from .cells import WiredCell
from .experiment import Experiment
from .felt_levels import contact_of, felt_db
from .own_parts import Unseen

TOLERATED_DB = 0.05
"""A level this far below the threshold is printed as at it."""


NEAR_DB = 10.0
"""A standard less than this above the threshold is near it: two standard deviations between people (unverified
default)."""


@dataclass(frozen=True)
class Unfelt:
    """A condition that nobody is predicted to feel: its strongest level, and the sensation level there."""

    condition: str
    level: str
    sensation_db: float | None
    is_standard: bool = False

    @property
    def line(self) -> str:
        """State the condition as a warning.

        >>> Unfelt("frequency_hz 60", "36 dB re 1 V", -28.74).line
        'WARNING: even the strongest level (36 dB re 1 V) is 28.7 dB below the predicted threshold at frequency_hz 60'
        >>> Unfelt("", "36 dB re 1 V", None).line
        'WARNING: even the strongest level (36 dB re 1 V) is not felt at all'
        >>> Unfelt("", "40 dB re 1 V", 2.5, is_standard=True).line.partition(":")[2][:67]
        ' the standard (40 dB re 1 V) is 2.5 dB above the predicted threshol'
        """
        where = f" at {self.condition}" if self.condition else ""
        if self.is_standard:
            return f"WARNING: the standard ({self.level}) is {self._distance}{where}: low levels are often not felt"
        if self.sensation_db is None:
            return f"WARNING: even the strongest level ({self.level}) is not felt at all{where}"
        return f"WARNING: even the strongest level ({self.level}) is {self._distance}{where}"

    @property
    def _distance(self) -> str:
        if self.sensation_db is None:
            return "not felt at all"
        side = "below" if self.sensation_db < 0 else "above"
        return f"{abs(self.sensation_db):.1f} dB {side} the predicted threshold"


def unfelt(experiment: Experiment, *, simulated: bool = False) -> Iterator[Unfelt]:
    """Yield the conditions of a study whose strongest level, or whose standard, is too weak.

    The physics predicts it; of `simulated` participants the thresholds that their observer states.
    """
    middle = experiment.people.middle
    for cell in experiment.cells.values():
        if isinstance(cell.sensation, Unseen):  # its code may not run
            continue
        factors = cell.condition.factors
        feeling = middle.stated(factors) if simulated and isinstance(middle, Stated) else Feeling()
        name = ", ".join(f"{factor} {cell_text(value)}" for factor, value in factors.items())
        for level, lowest_db, is_standard in _levels(experiment, cell):
            felt = feeling.felt_db(level, partial(felt_db, cell, level, contact_of(cell)))
            if felt < lowest_db:
                text = f"{level:g} {cell.stimulus.level_unit}"
                yield Unfelt(name, text, None if felt == -inf else felt, is_standard)
                break


def _levels(experiment: Experiment, cell: WiredCell) -> Iterator[tuple[float, float, bool]]:
    """Yield the strongest level and the standard, each with the lowest sensation level that needs no warning."""
    yield cell.procedure.rule.bounds[1], -TOLERATED_DB, False
    if isinstance(experiment.task, AgainstStandard):
        yield experiment.task.standard_level, NEAR_DB, True
