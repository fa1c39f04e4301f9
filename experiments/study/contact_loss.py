"""Fingers and tips that lose contact because the plate pulls too hard."""

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
    """Sensation model that computes the force between plate and fingers."""

    @property
    def pressers(self) -> tuple[str, ...]:
        """Names of the fingers that share the force of a touch."""

    def contact_force_n(self, signal: Signal, contact: Contact) -> FloatArray:
        """(n_samples,), or (n_fingers, n_samples): on top of what presses each."""


@dataclass(frozen=True)
class FingerOfStudy:
    """Finger (or tip) that the strongest stimulus pulls most at a force.

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
        """True if contact is lost at the highest level of the study."""
        return self.pull_n > self.force_n

    @property
    def line(self) -> str:
        """The prediction in one sentence."""
        at = f"at {self.level:g} {self.level_unit} ({self.stimulus})"
        pulled = f"the plate would pull a {self.presser} of {self.force_n:g} N by {self.pull_n:.2g} N"
        if not self.lifts_off:
            return f"contact holds: {at} {pulled} at most"
        first = f"{self.first_level:.3g} {self.level_unit}"
        return f"contact is lost: {at} {pulled}, so that it lifts off, from {first} on"


@dataclass(frozen=True)
class _Touch:
    """Finger (or tip) with an even share of the force of a touch."""

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
        """Return the largest pull of the plate, N."""
        force_n = np.atleast_2d(self.sensation.contact_force_n(signal, self.contact))[self.number]
        return max(-float(force_n.min(initial=0.0)), 0.0)


def pulled_fingers(experiment: Experiment) -> list[FingerOfStudy]:
    """Return the case nearest to lifting off per finger (or tip) and force.

    Empty for a study without a focus.
    """
    nearest: dict[tuple[float, str], tuple[float, Strongest, _Touch]] = {}
    strongest = {one.name: one for one in experiment.strongest()}
    for name, touch in _touches(experiment):
        pull_n, pressed = touch.pull_n(strongest[name].signal), (touch.force_n, touch.presser)
        if pull_n > nearest.get(pressed, (0.0,))[0]:
            nearest[pressed] = pull_n, strongest[name], touch
    return [_pulled(*nearest[pressed]) for pressed in sorted(nearest)]


def _touches(experiment: Experiment) -> Iterator[tuple[str, _Touch]]:
    """Yield each stimulus once per finger, plate model and force."""
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
