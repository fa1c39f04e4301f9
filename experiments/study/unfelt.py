"""Conditions whose strongest level lies below the predicted detection threshold."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from math import inf

from tactometry.observers.people import Feeling, Stated
from tactometry.trials.cells import cell as cell_text

from .experiment import Experiment
from .felt_levels import contact_of, felt_db
from .own_parts import Unseen

TOLERATED_DB = 0.05
"""A level this far below the threshold is printed as at it."""


@dataclass(frozen=True)
class Unfelt:
    """A condition that nobody is predicted to feel: its strongest level, and the sensation level there."""

    condition: str
    level: str
    sensation_db: float | None

    @property
    def line(self) -> str:
        """State the condition as a warning.

        >>> Unfelt("frequency_hz 60", "36 dB re 1 V", -28.74).line
        'WARNING: even the strongest level (36 dB re 1 V) is 28.7 dB below the predicted threshold at frequency_hz 60'
        >>> Unfelt("", "36 dB re 1 V", None).line
        'WARNING: even the strongest level (36 dB re 1 V) is not felt at all'
        """
        where = f" at {self.condition}" if self.condition else ""
        if self.sensation_db is None:
            return f"WARNING: even the strongest level ({self.level}) is not felt at all{where}"
        below = f"{-self.sensation_db:.1f} dB below the predicted threshold"
        return f"WARNING: even the strongest level ({self.level}) is {below}{where}"


def unfelt(experiment: Experiment, *, simulated: bool = False) -> Iterator[Unfelt]:
    """Yield the conditions of a study whose strongest level is below the predicted threshold.

    The physics predicts it; of `simulated` participants the thresholds that their observer states.
    """
    middle = experiment.people.middle
    for cell in experiment.cells.values():
        if isinstance(cell.sensation, Unseen):  # its code may not run
            continue
        level, factors = cell.procedure.rule.bounds[1], cell.condition.factors
        feeling = middle.stated(factors) if simulated and isinstance(middle, Stated) else Feeling()
        felt = feeling.felt_db(level, partial(felt_db, cell, level, contact_of(cell)))
        if felt < -TOLERATED_DB:
            name = ", ".join(f"{factor} {cell_text(value)}" for factor, value in factors.items())
            yield Unfelt(name, f"{level:g} {cell.stimulus.level_unit}", None if felt == -inf else felt)
