"""What of a study the plate throws off, fingers and tips: where a linear contact would pull by more than presses it."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, Protocol, runtime_checkable

import numpy as np

from tactometry.contact import Contact
from tactometry.errors import LimitExceeded
from tactometry.signal import Signal
from tactometry.stimuli.arrays import FloatArray

from .checks import Strongest
from .experiment import Experiment

STEPS: Final = 4
CLOSE: Final = 1e-3
"""Pull over pressing force, beside 1: at a voltage one step is exact, lengths of bursts take some."""


@runtime_checkable
class Pressed(Protocol):
    """A model of what is felt that knows the force between plate and fingers."""

    @property
    def pressers(self) -> tuple[str, ...]:
        """What shares the force of a touch, in words."""

    def contact_force_n(self, signal: Signal, contact: Contact) -> FloatArray:
        """(n_samples,), or (n_fingers, n_samples): on top of what presses each."""


@dataclass(frozen=True)
class FingerOfStudy:
    """The finger (or tip) under a force that the strongest stimulus pulls most, for its force.

    Parameters
    ----------
    stimulus, level_unit : str
    force_n : float
        That presses it.
    level : float
        The highest of the study.
    pull_n : float
        By which the plate pulls at most at that level.
    first_level : float
        From which on that is more than presses it.
    presser : str
        What it is.
    """

    stimulus: str
    level_unit: str
    force_n: float
    level: float
    pull_n: float
    first_level: float
    presser: str

    @property
    def lifts_off(self) -> bool:
        """Whether contact is lost at the highest level of the study."""
        return self.pull_n > self.force_n

    @property
    def line(self) -> str:
        """In one sentence."""
        at = f"at {self.level:g} {self.level_unit} ({self.stimulus})"
        pulled = f"the plate would pull a {self.presser} of {self.force_n:g} N by {self.pull_n:.2g} N"
        if not self.lifts_off:
            return f"contact holds: {at} {pulled} at most"
        first = f"{self.first_level:.3g} {self.level_unit}"
        return f"contact is lost: {at} {pulled}, so that it lifts off, from {first} on"


@dataclass(frozen=True)
class _Touch:
    """One of the fingers (or a tip) under the force of a touch, which they share evenly."""

    sensation: Pressed
    number: int
    contact: Contact

    @property
    def presser(self) -> str:
        return self.sensation.pressers[self.number]

    @property
    def force_n(self) -> float:
        return self.contact.force_n / len(self.sensation.pressers)

    def pull_n(self, signal: Signal) -> float:
        """By how much the plate would pull it at most."""
        force_n = np.atleast_2d(self.sensation.contact_force_n(signal, self.contact))[self.number]
        return max(-float(force_n.min(initial=0.0)), 0.0)


def pulled_fingers(experiment: Experiment) -> list[FingerOfStudy]:
    """Of each finger (or tip) and force that presses it the case that is nearest to lifting off; none of a study
    without a focus.
    """
    nearest: dict[tuple[float, str], tuple[float, Strongest, _Touch]] = {}
    strongest = {one.name: one for one in experiment.strongest()}
    for name, touch in _touches(experiment):
        pull_n, pressed = touch.pull_n(strongest[name].signal), (touch.force_n, touch.presser)
        if pull_n > nearest.get(pressed, (0.0,))[0]:
            nearest[pressed] = pull_n, strongest[name], touch
    return [_pulled(*nearest[pressed]) for pressed in sorted(nearest)]


def _touches(experiment: Experiment) -> Iterator[tuple[str, _Touch]]:
    """Each stimulus with each finger of each model on a plate under each force, once."""
    touches = {}
    for cell in experiment.cells.values():
        force_n = getattr(cell.condition.touch, "force_n", 0.0)
        if isinstance(cell.sensation, Pressed) and force_n > 0:
            touches[cell.condition.stimulus, repr(cell.sensation), force_n] = cell.sensation
    for (name, _, force_n), sensation in touches.items():
        for number in range(len(sensation.pressers)):
            yield name, _Touch(sensation, number, Contact(force_n))


def _pulled(pull_n: float, strongest: Strongest, touch: _Touch) -> FingerOfStudy:
    """With the level at which pull and pressing force are equal: each step takes the force to go with the amplitude."""
    stimulus, level, pulled_n, force_n = strongest.stimulus, strongest.level, pull_n, touch.force_n
    at_most = strongest.name, stimulus.level_unit, force_n, level, pull_n
    in_db = stimulus.level_unit.startswith("dB")
    for _ in range(STEPS):
        level = level - 20 * math.log10(pulled_n / force_n) if in_db else level * force_n / pulled_n
        try:
            pulled_n = touch.pull_n(stimulus.at(level))
        except LimitExceeded:
            break
        if abs(pulled_n / force_n - 1) < CLOSE:
            break
    return FingerOfStudy(*at_most, level, touch.presser)
