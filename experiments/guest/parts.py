"""The objects that a Builder experiment has of our components: begun by their routines, asked in each frame."""

import atexit
from collections.abc import Mapping
from functools import cache
from typing import Any

from tactometry.errors import Stopped
from tactometry.protocols.tasks.task import TrialOutcome
from tactometry.rigs.touch.touch import ConcurrentPlay

from .guest import Guest
from .loop import Loop, Values, of_stimulus, of_touch, of_trial

Factors = Mapping[str, float | str]


@cache
def guest_of(window: Any, study: str, bench: str) -> Guest:
    """The guest that all parts of an experiment share which name the same study and bench; closed with the program."""
    guest = Guest(window, study, bench or None)
    atexit.register(guest.close)
    return guest


class GuestPart:
    """A component: its guest, its cell, and what it leaves in the row under way."""

    def __init__(self, window: Any, study: str, bench: str, factors: Factors) -> None:
        self.guest, self.factors = guest_of(window, study, bench), dict(factors)
        self.status: Any = None  # PsychoPy's
        self.values: Values = {}


class TouchPart(GuestPart):
    """A touch on pages of ours and, where the study's question is asked, its answer."""

    def __init__(self, window: Any, study: str, bench: str, factors: Factors, *, asks: bool) -> None:
        super().__init__(window, study, bench, factors)
        self.asks, self.outcome = asks, TrialOutcome(())

    def run(self, level: float | None) -> bool:
        """To its end; False if Escape was pressed."""
        self.values = {}
        try:
            if self.asks:
                self.outcome = self.guest.trial(level, **self.factors)
                self.values = of_trial(self.outcome)
            else:
                self.values = of_touch(self.guest.touch(level, **self.factors))
        except Stopped:
            return False
        return True


class StimulusPart(GuestPart):
    """Stimulus that plays during a routine."""

    _beside: ConcurrentPlay | None = None
    stopped = False
    """Whether Escape was pressed while a sensor paused it."""

    def start(self, level: float | None) -> None:
        self.values = {}
        self._beside = self.guest.begin(level, **self.factors)

    def plays(self) -> bool:
        """In each frame."""
        try:
            return self._beside is not None and self._beside.look()
        except Stopped:
            self.stopped = True
            return False

    def finish(self) -> None:
        """With the routine: zero now."""
        if self._beside is not None:
            self.values = of_stimulus(self._beside.end()) | {"cut": int(self._beside.cut)}
            self._beside = None


class FormPart(GuestPart):
    """A questionnaire on pages of ours, a row for each item."""

    def run(self, name: str, experiment: Any) -> bool:
        """To its end; False if Escape was pressed."""
        try:
            self.guest.questionnaire(name, experiment)
        except Stopped:
            return False
        return True


def loop_of(name: str, window: Any, study: str, bench: str, factors: Factors) -> Loop:
    """The study's procedure, as the loop of this name."""
    return guest_of(window, study, bench).loop(name, **factors)
