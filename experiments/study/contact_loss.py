"""What of a study the plate throws off, fingers and tips: where a linear contact would pull by more than presses it."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, Protocol, runtime_checkable

from tactometry.contact import Contact
from tactometry.errors import LimitExceeded
from tactometry.signal import Signal
from tactometry.stimuli.arrays import FloatArray

from .experiment import Experiment, Strongest

STEPS: Final = 4
CLOSE: Final = 1e-3
"""Pull over pressing force, beside 1: at a voltage one step is exact, lengths of bursts take some."""


@runtime_checkable
class Pressed(Protocol):
    """A model of what is felt that knows the force between finger and plate."""

    def contact_force_n(self, signal: Signal, contact: Contact) -> FloatArray:
        """(n_samples,): on top of what presses the finger."""


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
    presser: str = "finger"

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


def pulled_fingers(experiment: Experiment) -> list[FingerOfStudy]:
    """Of each pressing force and what it presses the one that is nearest to lifting off; none of a study without a
    focus."""
    nearest: dict[tuple[str, float], tuple[float, Strongest, Pressed]] = {}
    strongest = {one.name: one for one in experiment.strongest()}
    for name, sensation, force_n in _touches(experiment):
        pull_n, pressed = _pull_n(strongest[name].signal, sensation, force_n), (_presser(sensation), force_n)
        if pull_n > nearest.get(pressed, (0.0,))[0]:
            nearest[pressed] = pull_n, strongest[name], sensation
    return [_pulled(*nearest[pressed], pressed[1]) for pressed in sorted(nearest)]


def _presser(sensation: Pressed) -> str:
    return str(getattr(sensation, "presser", "finger"))


def _touches(experiment: Experiment) -> Iterator[tuple[str, Pressed, float]]:
    """Each stimulus with each model of a finger on a plate and the force on each finger, once."""
    touches = {}
    for cell in experiment.cells.values():
        force_n = getattr(cell.condition.touch, "force_n", 0.0) / getattr(cell.sensation, "n_fingers", 1)
        if isinstance(cell.sensation, Pressed) and force_n > 0:
            touches[cell.condition.stimulus, repr(cell.sensation), force_n] = cell.sensation
    return ((name, sensation, force_n) for (name, _, force_n), sensation in touches.items())


def _pulled(pull_n: float, strongest: Strongest, sensation: Pressed, force_n: float) -> FingerOfStudy:
    """With the level at which pull and pressing force are equal: each step takes the force to go with the amplitude."""
    stimulus, level, pulled_n = strongest.stimulus, strongest.level, pull_n
    at_most = strongest.name, stimulus.level_unit, force_n, level, pull_n
    in_db = stimulus.level_unit.startswith("dB")
    for _ in range(STEPS):
        level = level - 20 * math.log10(pulled_n / force_n) if in_db else level * force_n / pulled_n
        try:
            pulled_n = _pull_n(stimulus.at(level), sensation, force_n)
        except LimitExceeded:
            break
        if abs(pulled_n / force_n - 1) < CLOSE:
            break
    return FingerOfStudy(*at_most, level, _presser(sensation))


def _pull_n(signal: Signal, sensation: Pressed, force_n: float) -> float:
    return max(-float(sensation.contact_force_n(signal, Contact(force_n)).min(initial=0.0)), 0.0)
